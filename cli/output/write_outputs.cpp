#include "cli/output/write_outputs.h"

#include <algorithm>
#include <array>
#include <iostream>
#include <span>
#include <string>
#include <utility>

#include "cli/output/error_map.h"
#include "cli/output/extra_channels.h"
#include "cli/output/labels/font.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/recipe.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"

namespace parray::output {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Returns the mean number of samples per pixel. If a time limit left pixels untraced, returns the
/// share of traced pixels instead.
std::string samples_text(const json& report) {
  const auto filled = report.value("filled_pixels", std::uint64_t{0});
  const auto mean = report.at("samples_per_pixel").get<double>();
  std::string text = mean_text(mean) + (mean == 1 ? " sample" : " samples") + " per pixel";
  if (filled > 0) {
    const double pixels = report.at("width").get<double>() * report.at("height").get<double>();
    const std::string side = std::to_string(report.at("fill_block").get<std::uint64_t>());
    text = formatted("%.3g", 100 * (1 - static_cast<double>(filled) / pixels)) +
           " % of them traced, the others filled in blocks of up to " + side + " x " + side;
  }
  return text;
}

void print_summary(const json& report, const OutputPaths& outputs, double elapsed) {
  const fs::path& file = outputs.image.empty() ? outputs.report : outputs.image;
  std::cout << "wrote " << file.string() << ": " << report.at("width") << " x "
            << report.at("height") << " pixels, " << samples_text(report) << ", "
            << error_text(report) << ", " << duration_text(elapsed) << ", "
            << with_unit(report.at("samples_per_second").get<double>(), "samples/s")
            << ", image_sha256 " << report.at("image_sha256").get<std::string>().substr(0, 16)
            << "\n";
}

}  // namespace

PictureDetail OutputPaths::wanted_detail() const {
  if (denoise) return PictureDetail::replicates;
  return std::ranges::any_of(aovs, is_statistic) || !error_map.empty() ? PictureDetail::statistics
                                                                       : PictureDetail::image;
}

bool OutputPaths::shows_postprocessing() const {
  const auto shows = [](const fs::path& path) { return !path.empty() && !can_hold_channels(path); };
  return shows(image) || shows(preview);
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return !a.empty() && !b.empty() &&
         (fs::equivalent(a, b, ignored) ||
          fs::absolute(a).lexically_normal() == fs::absolute(b).lexically_normal());
}

/// Throws InputError if two outputs are the same file. A preview may be the picture that it
/// becomes.
static void check_distinct(const OutputPaths& outputs) {
  const std::array<std::pair<const char*, fs::path>, 4> files{{{"preview", outputs.preview},
                                                               {"picture", outputs.image},
                                                               {"report", outputs.report},
                                                               {"error map", outputs.error_map}}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto& [name, file] = files.at(i);
    for (std::size_t other = i == 0 ? 2 : i + 1; other < files.size(); ++other) {
      if (!same_file(file, files.at(other).second)) continue;
      throw InputError(file.string() + ": " + name + " and " + files.at(other).first +
                       " need different files");
    }
  }
}

void check_not_inputs(const OutputPaths& outputs, const InputFiles& inputs) {
  for (const auto& file : {outputs.image, outputs.report, outputs.error_map, outputs.preview}) {
    inputs.check(file);
  }
}

void check_outputs(const OutputPaths& outputs, const InputFiles& inputs) {
  if (!outputs.image.empty()) check_image_path(outputs.image);
  if (!outputs.report.empty()) check_output_path(outputs.report);
  if (!outputs.aovs.empty() && !can_hold_channels(outputs.image)) {
    throw InputError("--aov " + text_of(outputs.aovs) + ": " + outputs.image.string() +
                     " cannot contain extra channels: write an EXR file (.exr)");
  }
  if (!outputs.error_map.empty()) {
    check_image_path(outputs.error_map);
    const Font there(error_map_letters(1));  // throws if the font of the legend is missing
  }
  if (!outputs.preview.empty()) check_image_path(outputs.preview);
  if (can_hold_channels(outputs.error_map)) {
    throw InputError("--error-map " + outputs.error_map.string() + ": write a PNG file (.png)");
  }
  check_distinct(outputs);
  check_not_inputs(outputs, inputs);
}

/// Adds the times of write_outputs() to the report. Writing took `write` seconds and ended at
/// `end`. Returns the total.
static double complete_seconds(json& parts, double write, Time end,
                               const std::optional<CommandTimes>& times) {
  parts["write"] = write;
  if (times) parts["submit"] = times->submit_seconds;
  double sum = 0;
  for (const auto& [name, value] : parts.items()) {
    const bool part_of_render = name == "build" || name == "deciding";
    sum += part_of_render ? 0 : value.get<double>();
  }
  const double total = times ? to_seconds(end - times->started) : sum;
  if (times) parts["other"] = std::max(total - sum, 0.0);
  parts["total"] = total;
  return total;
}

/// Returns whether the time limit is too close for a slow, small file.
static bool must_hurry(const OutputPaths& outputs, const Picture& picture,
                       const std::optional<CommandTimes>& times, Time now) {
  const double limit = picture.report.value("time_limit", 0.0);
  if (!times || !times->limited || limit == 0) return false;
  const PictureSize size{picture.image.width, picture.image.height, picture.channels.size()};
  return to_seconds(now - times->started) + write_seconds(outputs.image, size, false) > limit;
}

/// Returns alpha as the only channel that a PNG file can contain. Returns none for an opaque
/// picture.
static Channels alpha_alone(std::span<const float> alpha) {
  if (alpha.empty()) return {};
  return {{alpha_channel, std::vector<float>(alpha.begin(), alpha.end())}};
}

void write_picture(const fs::path& file, const Picture& picture, const OutputPaths& outputs,
                   bool fast) {
  const auto write = [&](const Image& image, ImageMetadata metadata, const Channels& channels) {
    if (outputs.dpi > 0) metadata.emplace_back(dpi_key, outputs.dpi);
    write_image(file, image, metadata, channels, check_interrupted, fast);
  };
  if (can_hold_channels(file)) {
    write(picture.image, recipe_metadata(picture), picture.channels);
    return;
  }
  if (outputs.finishing.empty()) {
    const Channels alpha = alpha_alone(alpha_of(picture.channels));
    write(picture.image, recipe_metadata(picture, picture.image, alpha), alpha);
    return;
  }
  const ShownPicture shown = finished_picture(picture, outputs.finishing);
  const Channels alpha = alpha_alone(shown.alpha);
  ImageMetadata metadata = recipe_metadata(picture, shown.image, alpha);
  metadata.emplace_back(finished_key, names_of(outputs.finishing));
  write(shown.image, std::move(metadata), alpha);
}

/// Writes the image. If that fails, saves the image to another folder, because it may contain hours
/// of work. The error names the folder.
static void write_or_save(const OutputPaths& outputs, const Picture& picture, bool fast) {
  try {
    write_picture(outputs.image, picture, outputs, fast);
  } catch (const RunError& failed) {
    std::error_code ignored;
    for (const fs::path& folder : {fs::temp_directory_path(ignored), fs::current_path(ignored)}) {
      const fs::path saved = folder / outputs.image.filename();
      if (folder.empty() || fs::exists(saved, ignored)) continue;
      try {
        write_picture(saved, picture, outputs, fast);
      } catch (const RunError&) {
        continue;
      }
      throw RunError(std::string(failed.what()) + ": the picture was saved to " + saved.string());
    }
    throw;
  }
}

/// Returns whether the picture has the bits of the original picture. Prints a warning if it does
/// not.
static bool has_original_bits(const json& report, const OriginalPicture& original) {
  const auto made = report.at("image_sha256").get<std::string>();
  if (original.image_sha256.empty() || made == original.image_sha256) return true;
  std::cerr
      << "parray: --like " + original.file + ": the new picture has different bits: image_sha256 " +
             made.substr(0, 16) + ", not " + printable(original.image_sha256.substr(0, 16)) +
             ": somebody changed the recipe, or this build of ParRay differs: if the recipe is "
             "unchanged, please send both pictures to the developers of ParRay\n";
  return false;
}

/// Returns whether all samples were finite. Prints a warning if they were not.
static bool all_finite(const json& report) {
  const auto nonfinite = report.at("nonfinite_samples").get<std::uint64_t>();
  if (nonfinite == 0) return true;
  const json located = report.value("nonfinite", json::array());
  std::cerr << "parray: warning: " << nonfinite << " of " << report.at("samples")
            << " samples were not finite and were left out of the picture";
  if (!located.empty()) {
    const json& first = located.front();
    std::cerr << ", the first in pixel (" << first.at("x") << ", " << first.at("y") << "), sample "
              << first.at("first_sample");
  }
  std::cerr << ": please send the scene file to the developers of ParRay\n";
  return false;
}

int write_outputs(Picture picture, const OutputPaths& outputs, std::optional<CommandTimes> times) {
  const SteadyClock clock;
  json& report = picture.report;
  const Time begin = clock.now();
  if (!outputs.legends.empty()) report["legends"] = json::parse(outputs.legends);
  if (!outputs.image.empty()) {
    if (can_hold_channels(outputs.image)) add_sample_counts(picture);
    write_or_save(outputs, picture, must_hurry(outputs, picture, times, begin));
  }
  if (!outputs.preview.empty() && !same_file(outputs.preview, outputs.image)) {
    write_picture(outputs.preview, picture, outputs);
  }
  if (!outputs.error_map.empty()) write_error_map(outputs.error_map, picture);
  const Time end = clock.now();
  const double total = complete_seconds(report.at("seconds"), to_seconds(end - begin), end, times);
  if (!outputs.notes.empty()) report["notes"] = outputs.notes;
  if (outputs.facts.is_object()) report.update(outputs.facts);
  if (!outputs.report.empty()) write_text_file(outputs.report, json_document(report));
  if (outputs.summary && !outputs.none()) print_summary(report, outputs, total);
  const bool original_bits = has_original_bits(report, outputs.original);
  return all_finite(report) && original_bits ? 0 : 1;
}

}  // namespace parray::output
