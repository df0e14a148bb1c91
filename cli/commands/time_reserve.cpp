#include "cli/commands/time_reserve.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/farm/direct_render.h"
#include "cli/output/extra_channels.h"
#include "cli/output/text.h"
#include "common/adaptive/replicates.h"
#include "common/image/image.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/report.h"

namespace parray::commands {
namespace {

/// Seconds for the steps between tracing and writing, under the present load of this machine.
struct EndingCost {
  double denoising = 0;
  double channels = 0;  ///< extra channels, also those for postprocessing
  /// Time for removing the background, as a share of the time for tracing.
  double background_share = 0;
};

using nlohmann::json;

constexpr std::uint32_t miniature_samples = 4;
/// Number of measurements. The shortest counts, because other processes may slow one down.
constexpr int trials = 3;
constexpr double never_ending = std::numeric_limits<double>::infinity();

/// Returns the settings of a miniature of the picture. Its size bounds the time: at most 6144
/// pixels and an eighth of the picture's (of a picture that is a few pixels wide or high, 36 %). So
/// it is traced in the time of half a sample of each pixel of the picture, or in some tens of
/// milliseconds of one thread. All trials together take at most three eighths of the time of the
/// picture's own steps.
RenderSettings miniature_of(const RenderSettings& whole) {
  constexpr double most_pixels = 6144;
  const double pixels = static_cast<double>(whole.width) * whole.height;
  const double scale = std::sqrt(std::min(most_pixels / pixels, 0.125));
  const auto scaled = [&](std::uint32_t side) {
    return std::max(static_cast<std::uint32_t>(scale * side), 1U);
  };
  RenderSettings settings = whole;
  settings.width = scaled(whole.width);
  settings.height = scaled(whole.height);
  settings.samples_per_pixel = miniature_samples;
  settings.adaptive = settings.target_denoised = false;
  settings.target_error = settings.target_half_width = settings.time_limit = 0;
  settings.passes = {};
  return settings;
}

Picture picture_of(const DirectRender& traced, const std::string& scene_id, bool replicates) {
  Picture picture;
  picture.image = resolve_image(traced.framebuffer, traced.largest_radiance);
  const auto samples = traced.framebuffer.samples();
  picture.statistics.samples.assign(samples.begin(), samples.end());
  if (replicates) picture.statistics.replicates = replicates_of(traced.state());
  picture.report = {{"scene_sha256", scene_id},
                    {"least_samples", miniature_samples},
                    {"most_samples", miniature_samples},
                    {"samples_per_pixel", miniature_samples},
                    {"seconds", json::object()}};
  return picture;
}

/// Does the steps after tracing for a miniature of the picture, and scales the times up. Builds the
/// accelerator, or takes the one of `extra`. `scene_id`: the scene's identity.
EndingCost ending_cost(const ExtraChannels& extra, const std::string& scene_id) {
  ExtraChannels small = extra;
  small.settings = miniature_of(extra.settings);
  // The number of samples of extra channels does not depend on the picture's: at most 16 per pixel.
  small.aovs.erase(Aov::half_width);
  small.denoised = nullptr;
  const auto tracer = tracer_of(small, scene_id);
  const std::atomic<bool> stop = false;
  const auto traced = render_directly(*tracer, *extra.scene, small.settings, extra.threads, stop);
  small.settings->samples_per_pixel = extra.settings->samples_per_pixel;
  const double times_as_large = static_cast<double>(pixel_count(extra.settings)) /
                                static_cast<double>(pixel_count(small.settings));
  EndingCost least{never_ending, never_ending, never_ending};
  for (int trial = 0; trial < trials; ++trial) {
    Picture picture = picture_of(*traced, scene_id, small.denoise);
    add_channels(picture, small);
    const auto took = [&](const char* what) {
      return picture.report.at("seconds").value(what, 0.0);
    };
    least.denoising = std::min(least.denoising, times_as_large * took("denoise"));
    least.channels = std::min(least.channels, times_as_large * took("aovs"));
    least.background_share =
        std::min(least.background_share, took("transparent") / std::max(traced->seconds, 1e-6));
  }
  return least;
}

/// Returns the seconds for postprocessing, labels and the error map.
double drawing_seconds(const OutputPaths& outputs, double pixels) {
  constexpr double postprocessing_a_pixel = 150e-9;
  constexpr double map_a_pixel = 100e-9;
  return (outputs.error_map.empty() ? 0 : map_a_pixel * pixels) +
         (outputs.finishing.empty() ? 0 : postprocessing_a_pixel * pixels);
}

void print_note(const TimeShare& share, const std::string& text) {
  std::cerr << "parray: " + share.name + ": " + text + "\n";
}

/// Prints once that the step `what` is left out. `printed`: whether this has been printed.
void leave_out(TimeShare& share, bool TimeShare::*printed, const char* what, double seconds) {
  if (!(share.*printed)) {
    print_note(share,
               what + (" takes about " + duration_text(seconds)) + ", which is too long: left out");
  }
  share.*printed = true;
}

}  // namespace

void reserve_time(PreparedRender& render, std::function<double()> elapsed) {
  const RenderSettings& settings = render.submission.settings;
  const double limit = settings.time_limit;
  if (limit <= 0) return;
  const OutputPaths& outputs = render.outputs;
  const std::size_t channels =
      (settings.adaptive ? 1U : 0U) + (outputs.transparent ? 1U : 0U) + (outputs.denoise ? 3U : 0U);
  TimeShare share = {limit, "--time-limit " + number_cell(limit),
                     writing_seconds(outputs, {settings.width, settings.height, channels}, limit),
                     std::move(elapsed)};
  render.submission.reserved_seconds = reserve_time(share, render);
}

double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit) {
  // The system starts the process before `main`, and frees its memory at the end.
  constexpr double outside = 0.02;
  constexpr double outside_a_pixel = 8e-9;
  const auto pixels = static_cast<double>(size.width * size.height);
  const auto writing = [&](const std::filesystem::path& file, bool fast) {
    return file.empty() ? 0 : write_seconds(file, size, fast);
  };
  const double image = writing(outputs.image, false);
  const bool haste = image > limit / 10;
  return outside + outside_a_pixel * pixels + (haste ? writing(outputs.image, true) : image) +
         writing(outputs.preview, false) + writing(outputs.error_map, false);
}

double reserve_time(TimeShare& share, PreparedRender& render) {
  auto& [submission, outputs, extra] = render;
  RenderSettings& settings = submission.settings;
  constexpr double most = 0.85;  // share of the limit; the rest is for tracing
  const EndingCost cost =
      extra.scene ? ending_cost(extra, scene_identity(*submission.scene)) : EndingCost();
  const double ending = ending_times(settings, 0, 0).total;  // the coordinator reserves it
  const double pixels = static_cast<double>(settings.width) * settings.height;
  double reserved = share.elapsed() + share.writing + drawing_seconds(outputs, pixels);
  const auto add_if_it_fits = [&](double needed) {
    const bool fits = reserved + ending + needed <= most * share.seconds;
    reserved += fits ? needed : 0;
    return fits;
  };
  if (outputs.denoise && (share.without_denoising || !add_if_it_fits(cost.denoising))) {
    leave_out(share, &TimeShare::without_denoising, "denoising", cost.denoising * share.parts);
    outputs.denoise = extra.denoise = settings.replicates = settings.target_denoised = false;
    submission.denoise = false;
    extra.settings = settings;
  }
  if (cost.channels > 0 && (share.without_channels || !add_if_it_fits(cost.channels))) {
    leave_out(share, &TimeShare::without_channels, "tracing extra channels",
              cost.channels * share.parts);
    outputs.aovs = extra.aovs = extra.for_postprocessing = {};
    std::erase_if(outputs.finishing,
                  [](const PostprocessStep& step) { return !step.needs.empty(); });
  }
  if (reserved + ending > share.seconds && !share.without_time) {
    share.without_time = true;
    const double least = share.elsewhere + share.parts * (reserved + ending);
    print_note(share, "loading and writing alone take about " + duration_text(least) +
                          ": as little as possible is traced");
  }
  const double left = std::max(share.seconds - reserved - ending, 0.0);
  return reserved + left * cost.background_share / (1 + cost.background_share);
}

}  // namespace parray::commands
