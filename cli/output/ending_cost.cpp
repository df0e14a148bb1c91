#include "cli/output/ending_cost.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/farm/direct_render.h"
#include "common/adaptive/replicates.h"
#include "common/image/image.h"

namespace parray {
namespace {

using nlohmann::json;

constexpr std::uint32_t miniature_samples = 4;

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
  Picture picture = picture_of(*traced, scene_id, small.denoise);
  small.settings.samples_per_pixel = extra.settings.samples_per_pixel;
  add_channels(picture, small);
  const auto pixels = [](const RenderSettings& settings) {
    return static_cast<double>(settings.width) * settings.height;
  };
  const json& times = picture.report.at("seconds");
  const double times_as_large = pixels(extra.settings) / pixels(small.settings);
  EndingCost cost;
  cost.denoising = times_as_large * times.value("denoise", 0.0);
  cost.channels = times_as_large * times.value("aovs", 0.0);
  if (traced->seconds > 0) {
    cost.background_share = times.value("transparent", 0.0) / traced->seconds;
  }
  return cost;
}

}  // namespace parray
