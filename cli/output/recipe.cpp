#include "cli/output/recipe.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "cli/output/picture/transparency.h"
#include "common/adaptive/passes.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/scene/settings_fields.h"
#include "proto/messages.h"

namespace parray::output {
namespace {

using nlohmann::json;

/// Returns the key of a value in the file.
std::string key(std::string_view name) { return "parray:" + std::string(name); }

/// Returns the fields of the report that an image file also contains.
std::vector<std::string> kept_in_image() {
  std::vector<std::string> keys = {"version", "trace_version", "scene_sha256", "image_sha256"};
  const auto add = [&keys](const Setting& setting, const auto& /*rule*/) {
    if (setting.is(traits::recipe)) keys.emplace_back(setting.key);
  };
  picture_fields(add);
  work_fields(add);
  keys.insert(keys.end(), {"samples", "least_samples", "most_samples"});
  stop_fields(add);
  keys.insert(keys.end(), {"stopped_by", "nonfinite_samples", "flag", "filled_pixels", "fill_block",
                           "channel_samples"});
  return keys;
}

void add_value(ImageMetadata& metadata, const std::string& name, const json& value) {
  if (value.is_string() && !value.get_ref<const std::string&>().empty()) {
    metadata.emplace_back(key(name), value.get<std::string>());
  } else if (value.is_boolean()) {
    metadata.emplace_back(key(name), std::uint64_t{value.get<bool>() ? 1U : 0U});
  } else if (value.is_number_unsigned()) {
    metadata.emplace_back(key(name), value.get<std::uint64_t>());
  } else if (value.is_number_float()) {
    metadata.emplace_back(key(name), value.get<double>());
  }
}

/// Returns the numbers in the form of option --passes.
std::string comma_list(const json& numbers) {
  std::string text;
  for (const json& number : numbers) text += (text.empty() ? "" : ",") + number.dump();
  return text;
}

/// Reads the values of one file's recipe.
class RecipeReader {
 public:
  RecipeReader(const ImageMetadata& metadata, const std::string& file)
      : metadata_(metadata), file_(file) {}

  [[nodiscard]] std::string text(const std::string& name) const {
    return needed(text_in(metadata_, key(name)), name);
  }
  template <typename Whole>
  [[nodiscard]] Whole whole(const std::string& name) const {
    const std::uint64_t value = needed(whole_in(metadata_, key(name)), name);
    if (value > std::numeric_limits<Whole>::max()) refuse(name);
    return static_cast<Whole>(value);
  }
  /// Returns the number. Returns 0 if it is missing.
  [[nodiscard]] double limit(const std::string& name) const {
    return real_in(metadata_, key(name)).value_or(0);
  }
  [[nodiscard]] bool has(const std::string& name) const {
    return std::ranges::any_of(metadata_,
                               [&](const auto& pair) { return pair.first == key(name); });
  }
  [[nodiscard]] std::vector<std::uint64_t> numbers(const std::string& name) const {
    const json list = json::parse("[" + text(name) + "]", nullptr, false);
    std::vector<std::uint64_t> numbers;
    for (const json& number : list) {
      if (!number.is_number_unsigned()) refuse(name);
      numbers.push_back(number.get<std::uint64_t>());
    }
    if (numbers.empty()) refuse(name);
    return numbers;
  }
  [[noreturn]] void refuse(const std::string& name) const {
    throw InputError(
        file_ + ": the recipe is damaged: " + key(name) +
        " is missing or not valid: use a copy of the original file, or the version of ParRay "
        "that wrote it");
  }

 private:
  template <typename Value>
  [[nodiscard]] Value needed(std::optional<Value> value, const std::string& name) const {
    if (!value) refuse(name);
    return *std::move(value);
  }

  const ImageMetadata& metadata_;
  const std::string& file_;
};

RenderSettings settings_in(const RecipeReader& reader, bool equal_samples) {
  RenderSettings settings;
  picture_fields(
      [&](const Setting& setting, const auto& rule, auto& value) {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_enum_v<T>) {
          value = static_cast<T>(index_in(rule, reader.text(setting.key)));
          if (setting.is(traits::resolved) && value == T{}) reader.refuse(setting.key);
        } else {
          value = reader.whole<T>(setting.key);
        }
      },
      settings);
  if (equal_samples) {
    settings.samples_per_pixel = reader.whole<std::uint32_t>("samples_per_pixel");
  } else {
    settings.adaptive = true;
    settings.passes = reader.numbers("passes");
    settings.target_half_width = reader.limit("target_half_width");  // influences where samples go
  }
  check_settings(settings);
  if (!problem_with_first_passes(settings).empty()) reader.refuse("passes");
  return settings;
}

void check_there(const RecipeReader& reader, const std::string& file) {
  if (reader.has("partial")) {
    throw InputError(file + ": an unfinished picture has no recipe: use the finished one");
  }
  if (!reader.has("image_sha256") || !reader.has("trace_version")) {
    throw InputError(
        file +
        ": the file has no recipe: use an EXR, PNG or TIFF picture that ParRay wrote and no other "
        "program changed");
  }
}

std::string start_of(const std::string& sha256) { return printable(sha256.substr(0, 16)); }

}  // namespace

bool samples_differ(const json& report) {
  return report.value("least_samples", 0U) != report.value("most_samples", 0U);
}

ImageMetadata recipe_metadata(const Picture& picture) {
  const json& report = picture.report;
  ImageMetadata metadata = {{"Software", "ParRay " + report.value("version", "")}};
  for (const std::string& key : kept_in_image()) {
    if (report.contains(key)) add_value(metadata, key, report.at(key));
  }
  if (!samples_differ(report)) {
    add_value(metadata, "samples_per_pixel", report.at("samples_per_pixel"));
  }
  const json passes = report.value("passes", json::array());
  if (!passes.empty()) metadata.emplace_back(key("passes"), comma_list(passes));
  const json error = report.value("error", json::object());
  for (const auto& [name, value] : error.items()) add_value(metadata, "error:" + name, value);
  if (report.contains("legends")) {
    metadata.emplace_back(key("legends"), report.at("legends").dump());
  }
  for (const std::string done : {"denoised", "transparent"}) {
    const json facts = report.value(done, json::object());
    for (const auto& [name, value] : facts.items()) add_value(metadata, done + ":" + name, value);
  }
  return metadata;
}

ImageMetadata recipe_metadata(const Picture& picture, const Image& shown, const Channels& alpha) {
  ImageMetadata metadata = recipe_metadata(picture);
  const auto bytes = png_bytes(shown, alpha);
  metadata.emplace_back(key("pixels_sha256"), sha256_hex(std::as_bytes(std::span(bytes))));
  return metadata;
}

Recipe recipe_in(const ImageMetadata& metadata, const std::string& file) {
  const RecipeReader reader(metadata, file);
  check_there(reader, file);
  Recipe recipe;
  recipe.image_sha256 = reader.text("image_sha256");
  recipe.pixels_sha256 = text_in(metadata, key("pixels_sha256")).value_or("");
  recipe.finished = text_in(metadata, finished_key).value_or("");
  recipe.denoised_sha256 = text_in(metadata, key("denoised:image_sha256")).value_or("");
  recipe.transparent_sha256 = text_in(metadata, key("transparent:image_sha256")).value_or("");
  recipe.scene_sha256 = reader.text("scene_sha256");
  recipe.trace_version = reader.whole<std::uint64_t>("trace_version");
  recipe.version = reader.text("version");
  recipe.samples = reader.whole<std::uint64_t>("samples");
  recipe.equal_samples = reader.has("samples_per_pixel");
  if (reader.has("channel_samples")) {
    recipe.channel_samples = reader.whole<std::uint32_t>("channel_samples");
  }
  try {
    recipe.settings = settings_in(reader, recipe.equal_samples);
  } catch (const InputError& error) {
    const std::string reason = error.what();
    throw InputError(reason.starts_with(file) ? reason
                                              : file + ": the recipe is damaged: " + reason);
  }
  return recipe;
}

void check_recipe(const Recipe& recipe, const std::string& picture, const std::string& scene_sha256,
                  const std::string& scene) {
  if (recipe.trace_version != trace_version) {
    throw InputError(picture + ": the picture was traced by other rules (trace_version " +
                     std::to_string(recipe.trace_version) + ", here " +
                     std::to_string(trace_version) + "): use ParRay " +
                     printable(recipe.version, 40));
  }
  if (recipe.scene_sha256 != scene_sha256) {
    throw InputError(
        scene + ": this is not the scene of " + picture +
        ": the picture's scene has scene_sha256 " + start_of(recipe.scene_sha256) +
        "..., this one " + start_of(scene_sha256) +
        "...: name the picture's scene. If that is a particle file, repeat the options "
        "of the picture (parray verify takes none), or name the scene file that parray "
        "convert writes with these options and with --width and --height");
  }
}

}  // namespace parray::output
