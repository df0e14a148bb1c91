#include "cli/output/extra_channels.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "cli/output/channel_tracing.h"
#include "cli/output/denoising.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/recipe.h"
#include "cli/output/write_outputs.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "proto/clock.h"

namespace parray::output {

bool needs_scene(const OutputPaths& outputs, const RenderSettings& settings) {
  return settings.replicates || outputs.transparent || !needs_of(outputs.finishing).empty() ||
         !std::ranges::all_of(outputs.aovs, is_statistic);
}

ExtraChannels extra_channels(const OutputPaths& outputs, const RenderSettings& settings,
                             std::shared_ptr<const Scene> scene, int threads) {
  return {.aovs = outputs.aovs,
          .settings = settings,
          .scene = needs_scene(outputs, settings) ? std::move(scene) : nullptr,
          .threads = threads,
          .for_postprocessing = needs_of(outputs.finishing),
          .denoise = settings.replicates,
          .transparent = outputs.transparent};
}

ExtraChannels extra_channels(const OutputPaths& outputs) {
  return extra_channels(outputs, RenderSettings{}, nullptr, 1);
}

bool wants_statistics(const Aovs& aovs) { return std::ranges::any_of(aovs, is_statistic); }

std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id) {
  auto accelerator = extra.accelerators->find(scene_id, extra.settings);
  if (!accelerator) {
    accelerator = extra.accelerators->build(scene_id, *extra.scene, extra.settings, extra.threads);
  }
  return make_path_tracer(std::move(accelerator), extra.scene->camera, extra.settings);
}

namespace {

void add_statistics(Picture& picture, const Aovs& aovs) {
  if (aovs.contains(Aov::samples)) {
    picture.channels.push_back({samples_channel, picture.statistics.samples});
  }
  if (!aovs.contains(Aov::half_width)) return;
  const std::vector<float>& all = picture.statistics.half_width;
  for (const std::size_t c : {0U, 1U, 2U}) {
    std::vector<float> values(all.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = all[3 * i + c];
    picture.channels.push_back({std::string("half_width.") + "RGB"[c], std::move(values)});
  }
}

/// Returns the number of samples of each pixel.
std::vector<std::uint32_t> samples_of(const Picture& picture) {
  const std::size_t pixels = picture.image.rgb.size() / 3;
  if (samples_differ(picture.report)) {
    if (picture.statistics.samples.size() == pixels) return picture.statistics.samples;
    throw RunError(
        "the background cannot be removed, because the coordinator has not sent the number of "
        "samples of each pixel: use the same version of ParRay on all machines");
  }
  return std::vector(pixels, picture.report.at("samples_per_pixel").get<std::uint32_t>());
}

void remove_background(Picture& picture, const PathTracer& tracer, const ExtraChannels& extra) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const std::vector<std::uint32_t> samples = samples_of(picture);
  const std::vector<SkySamples> sky =
      trace_sky_samples(tracer, extra.settings, samples, extra.threads, check_interrupted);
  std::vector<float> alpha =
      remove_sky(picture.image, sky, samples, RadianceScale(largest_radiance(*extra.scene)));
  const double covered = std::accumulate(alpha.begin(), alpha.end(), 0.0);
  picture.report["transparent"] = {{"image_sha256", transparent_sha256(picture.image, alpha)},
                                   {"covered", covered / static_cast<double>(alpha.size())}};
  picture.channels.push_back({alpha_channel, std::move(alpha)});
  picture.report.at("seconds")["transparent"] = to_seconds(clock.now() - begin);
}

void add_aovs(Picture& picture, const PathTracer* tracer, const ExtraChannels& extra) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const auto trace = [&](const Aovs& wanted, Channels& into) {
    if (tracer == nullptr || std::ranges::all_of(wanted, is_statistic)) return;
    Channels traced = trace_channels(*tracer, *extra.scene, extra.settings, wanted, extra.threads,
                                     check_interrupted);
    std::move(traced.begin(), traced.end(), std::back_inserter(into));
    picture.report["channel_samples"] =
        std::min(extra.settings->samples_per_pixel, channel_samples);
  };
  trace(extra.aovs, picture.channels);
  Aovs others;
  std::set_difference(extra.for_postprocessing.begin(), extra.for_postprocessing.end(),
                      extra.aovs.begin(), extra.aovs.end(), std::inserter(others, others.end()));
  trace(others, picture.traced);
  add_statistics(picture, extra.aovs);
  for (const Aov aov : extra.aovs) picture.report["aovs"].push_back(name_of(aov));
  picture.report.at("seconds")["aovs"] = to_seconds(clock.now() - begin);
}

}  // namespace

void add_sample_counts(Picture& picture) {
  const auto is_samples = [](const Channel& channel) { return channel.name == samples_channel; };
  if (samples_differ(picture.report) && !picture.statistics.samples.empty() &&
      std::ranges::none_of(picture.channels, is_samples)) {
    picture.channels.push_back({samples_channel, picture.statistics.samples});
  }
}

void add_channels(Picture& picture, const ExtraChannels& extra) {
  std::unique_ptr<PathTracer> tracer;
  if (extra.scene) tracer = tracer_of(extra, picture.report.at("scene_sha256"));
  if (extra.denoise) denoise_picture(picture, *tracer, extra);
  if (extra.transparent) remove_background(picture, *tracer, extra);
  if (!extra.aovs.empty() || !extra.for_postprocessing.empty()) {
    add_aovs(picture, tracer.get(), extra);
  }
}

}  // namespace parray::output
