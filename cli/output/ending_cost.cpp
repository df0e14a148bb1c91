#include "cli/output/ending_cost.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "cli/farm/direct_render.h"
#include "common/adaptive/replicates.h"
#include "common/image/image.h"

namespace parray::output {
namespace {

using nlohmann::json;

constexpr std::uint32_t miniature_samples = 4;
/// Other processes may disturb one: the shortest counts.
constexpr int trials = 3;
constexpr double never_ending = std::numeric_limits<double>::infinity();

/// Some tens of milliseconds for one thread, or an eighth of what the picture takes.
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

}  // namespace

EndingCost ending_cost(const ExtraChannels& extra, const std::string& scene_id) {
  ExtraChannels small = extra;
  small.settings = miniature_of(extra.settings);
  // Channels of a picture have up to 16 samples a pixel, whatever the picture has.
  small.aovs.erase(Aov::half_width);
  small.denoised = nullptr;
  const auto tracer = tracer_of(small, scene_id);
  const std::atomic<bool> stop = false;
  const auto traced = render_directly(*tracer, *extra.scene, small.settings, extra.threads, stop);
  small.settings.samples_per_pixel = extra.settings.samples_per_pixel;
  const auto pixels = [](const RenderSettings& settings) {
    return static_cast<double>(settings.width) * settings.height;
  };
  const double times_as_large = pixels(extra.settings) / pixels(small.settings);
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

}  // namespace parray::output
