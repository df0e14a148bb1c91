#include "common/scene/settings.h"

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray::scene {
namespace {

// Each table is indexed by its enum's values.
constexpr std::array<std::string_view, 4> precision_names{"auto", "f32", "f64", "mixed"};
constexpr std::array<std::string_view, 4> accelerator_names{"auto", "linear", "bvh", "octree"};
constexpr std::array<std::string_view, 5> isa_names{"auto", "scalar", "avx2", "avx512", "neon"};
constexpr std::array<std::string_view, 2> sampler_names{"independent", "sobol"};
constexpr std::array<std::string_view, 4> schedule_names{"static", "guided", "factoring",
                                                         "weighted"};
constexpr std::array<std::string_view, 3> row_order_names{"auto", "sequential", "interleaved"};

using Names = std::span<const std::string_view>;

template <typename Enum>
std::string_view name_in(Names names, Enum value) {
  const auto index = static_cast<std::size_t>(value);
  return index < names.size() ? names[index] : "unknown";
}

template <typename Enum>
Enum value_in(Names names, std::string_view what, std::string_view name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<Enum>(i);
  }
  NearestWord nearest(name);
  for (const std::string_view known : names) nearest.offer(known);
  std::string message = "unknown " + std::string(what) + " '" + printable(name) + "': ";
  if (!nearest.best().empty()) message += "did you mean '" + nearest.best() + "'? ";
  throw InputError(message + "known: " + list_names(names));
}

void check_range(std::string_view what, std::uint64_t value, std::uint64_t most) {
  if (value >= 1 && value <= most) return;
  throw InputError(std::string(what) + ": " + std::to_string(value) +
                   " is out of range: use a whole number from 1 to " + std::to_string(most));
}

template <typename Enum>
void check_known(std::string_view what, Names names, Enum value) {
  const auto index = static_cast<std::size_t>(value);
  if (index < names.size()) return;
  throw InputError(std::string(what) + ": value " + std::to_string(index) +
                   " has no meaning: known: " + list_names(names));
}

/// 0, for none, or in the range.
void check_limit(const char* name, double value, const NumberRange& range) {
  if (value != 0 && !(value >= range.least && value <= range.most)) {
    throw InputError(std::string(name) + " " + number_text(value) + " is out of range: use " +
                     number_text(range.least) + " to " + number_text(range.most));
  }
}

void check_passes(const RenderSettings& settings) {
  const std::uint64_t most =
      std::uint64_t{settings.width} * settings.height * limits::max_samples_per_pixel;
  if (settings.passes.size() > limits::max_passes) {
    throw InputError("too many passes: at most " + std::to_string(limits::max_passes));
  }
  for (const std::uint64_t samples : settings.passes) {
    if (samples == 0 || samples > most) {
      throw InputError("a pass of " + std::to_string(samples) + " samples: use 1 to " +
                       std::to_string(most));
    }
  }
}

}  // namespace

std::string_view name_of(Precision value) { return name_in(precision_names, value); }
std::string_view name_of(AcceleratorKind value) { return name_in(accelerator_names, value); }
std::string_view name_of(Isa value) { return name_in(isa_names, value); }
std::string_view name_of(Sampler value) { return name_in(sampler_names, value); }
std::string_view name_of(SchedulePolicy value) { return name_in(schedule_names, value); }
std::string_view name_of(RowOrder value) { return name_in(row_order_names, value); }

Precision precision_from(std::string_view name) {
  return value_in<Precision>(precision_names, "precision", name);
}

AcceleratorKind accelerator_from(std::string_view name) {
  return value_in<AcceleratorKind>(accelerator_names, "accelerator", name);
}
Isa isa_from(std::string_view name) { return value_in<Isa>(isa_names, "instruction set", name); }

Sampler sampler_from(std::string_view name) {
  return value_in<Sampler>(sampler_names, "sampler", name);
}

SchedulePolicy schedule_from(std::string_view name) {
  return value_in<SchedulePolicy>(schedule_names, "schedule", name);
}

RowOrder row_order_from(std::string_view name) {
  return value_in<RowOrder>(row_order_names, "row order", name);
}

void check_settings(const RenderSettings& settings) {
  check_range("width", settings.width, limits::max_image_side);
  check_range("height", settings.height, limits::max_image_side);
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  if (pixels > limits::max_pixels) {
    throw InputError("image of " + std::to_string(settings.width) + " x " +
                     std::to_string(settings.height) + " pixels is too large: use at most " +
                     std::to_string(limits::max_pixels) + " pixels");
  }
  check_range("samples_per_pixel", settings.samples_per_pixel, limits::max_samples_per_pixel);
  check_range("max_depth", settings.max_depth, limits::max_depth);
  check_limit("target_error", settings.target_error, ranges::target_error);
  check_limit("target_half_width", settings.target_half_width, ranges::target_error);
  check_limit("time_limit", settings.time_limit, ranges::time_limit);
  check_passes(settings);
  check_known("sampler", sampler_names, settings.sampler);
  check_known("precision", precision_names, settings.precision);
  check_known("isa", isa_names, settings.isa);
  check_known("accelerator", accelerator_names, settings.accelerator);
  check_known("schedule", schedule_names, settings.schedule);
  check_known("row order", row_order_names, settings.row_order);
}

}  // namespace parray::scene
