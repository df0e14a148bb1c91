#include "common/scene/settings.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/settings_fields.h"

namespace parray::scene {
namespace {

void check_whole(const Setting& setting, IntegerRange range, std::uint64_t value) {
  if (value >= range.least && value <= range.most) return;
  throw InputError(std::string(setting.key) + ": " + std::to_string(value) +
                   " is out of range: use a whole number from " + std::to_string(range.least) +
                   " to " + std::to_string(range.most));
}

void check_real(const Setting& setting, NumberRange range, double value) {
  if (value == 0 || (value >= range.least && value <= range.most)) return;
  throw InputError(std::string(setting.key) + " " + number_text(value) + " is out of range: use " +
                   number_text(range.least) + " to " + number_text(range.most));
}

void check_word(const Setting& setting, const Words& words, std::size_t index) {
  if (index < words.names.size()) return;
  std::string name = setting.key;
  std::ranges::replace(name, '_', ' ');
  throw InputError(name + ": value " + std::to_string(index) +
                   " is unknown: known: " + list_names(words.names));
}

void check_pixels(const RenderSettings& settings) {
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  if (pixels <= limits::max_pixels) return;
  throw InputError("image of " + std::to_string(settings.width) + " x " +
                   std::to_string(settings.height) + " pixels is too large: use at most " +
                   std::to_string(limits::max_pixels) + " pixels");
}

void check_passes(const RenderSettings& settings) {
  const std::uint64_t most =
      std::uint64_t{settings.width} * settings.height * limits::max_samples_per_pixel;
  if (settings.passes.size() > limits::max_passes) {
    throw InputError("too many passes: use at most " + std::to_string(limits::max_passes));
  }
  for (const std::uint64_t samples : settings.passes) {
    if (samples == 0 || samples > most) {
      throw InputError("a pass of " + std::to_string(samples) + " samples: use 1 to " +
                       std::to_string(most));
    }
  }
}

}  // namespace

std::string keyword_of(const Setting& setting) {
  return setting.keyword != nullptr ? setting.keyword : setting.key;
}

std::string option_of(const Setting& setting) {
  std::string name = keyword_of(setting);
  std::ranges::replace(name, '_', '-');
  return "--" + name;
}

std::string_view name_in(const Words& words, std::size_t index) {
  return index < words.names.size() ? words.names[index] : "unknown";
}

std::size_t index_in(const Words& words, std::string_view name) {
  const auto found = std::ranges::find(words.names, name);
  if (found != words.names.end()) return static_cast<std::size_t>(found - words.names.begin());
  NearestWord nearest(name);
  for (const std::string_view known : words.names) nearest.offer(known);
  std::string message = "unknown " + std::string(words.what) + " '" + printable(name) + "': ";
  if (!nearest.best().empty()) message += "did you mean '" + nearest.best() + "'? ";
  throw InputError(message + "known: " + list_names(words.names));
}

static std::string_view named(const Words& words, auto choice) {
  return name_in(words, static_cast<std::size_t>(choice));
}
std::string_view name_of(Precision value) { return named(words::precision, value); }
std::string_view name_of(AcceleratorKind value) { return named(words::accelerator, value); }
std::string_view name_of(Isa value) { return named(words::isa, value); }
std::string_view name_of(Sampler value) { return named(words::sampler, value); }
std::string_view name_of(SchedulePolicy value) { return named(words::schedule, value); }
std::string_view name_of(RowOrder value) { return named(words::row_order, value); }

Precision precision_from(std::string_view name) {
  return static_cast<Precision>(index_in(words::precision, name));
}
AcceleratorKind accelerator_from(std::string_view name) {
  return static_cast<AcceleratorKind>(index_in(words::accelerator, name));
}
Isa isa_from(std::string_view name) { return static_cast<Isa>(index_in(words::isa, name)); }
Sampler sampler_from(std::string_view name) {
  return static_cast<Sampler>(index_in(words::sampler, name));
}
SchedulePolicy schedule_from(std::string_view name) {
  return static_cast<SchedulePolicy>(index_in(words::schedule, name));
}
RowOrder row_order_from(std::string_view name) {
  return static_cast<RowOrder>(index_in(words::row_order, name));
}

void check_settings(const RenderSettings& settings) {
  settings_fields(
      [](const Setting& setting, const auto& rule, const auto& value) {
        using Rule = std::decay_t<decltype(rule)>;
        if constexpr (std::is_same_v<Rule, IntegerRange>) check_whole(setting, rule, value);
        if constexpr (std::is_same_v<Rule, NumberRange>) check_real(setting, rule, value);
        if constexpr (std::is_same_v<Rule, Words>) {
          check_word(setting, rule, static_cast<std::size_t>(value));
        }
      },
      settings);
  check_pixels(settings);
  check_passes(settings);
}

std::uint32_t width_of(const RenderSettings& settings) { return settings.width; }

std::uint32_t height_of(const RenderSettings& settings) { return settings.height; }

std::uint64_t pixel_count(const RenderSettings& settings) {
  return std::uint64_t{settings.width} * settings.height;
}

std::uint32_t max_depth_of(const RenderSettings& settings) { return settings.max_depth; }

std::uint32_t samples_per_pixel_of(const RenderSettings& settings) {
  return settings.samples_per_pixel;
}

const PictureSettings& picture_of(const RenderSettings& settings) { return settings; }

}  // namespace parray::scene

template class parray::base::Boxed<parray::scene::RenderSettings>;
