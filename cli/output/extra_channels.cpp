#include "cli/output/extra_channels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "cli/output/channel_tracing.h"
#include "cli/output/denoise/denoise.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/recipe.h"
#include "cli/output/write_outputs.h"
#include "common/adaptive/error_estimate.h"
#include "common/adaptive/replicates.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "common/trace/tracer.h"
#include "proto/clock.h"

namespace parray::output {

/// The state of an earlier denoising of the same picture.
struct DenoisedSoFar {
  std::uint64_t samples = 0;  ///< number of samples in total at that time
  std::uint32_t least = 0;    ///< argument `samples` of trace_features() for `features`
  Features features;
  Denoised picture;
};

namespace {

/// Updates `so_far` to the picture with these halves and numbers of samples per pixel.
void denoise_again(DenoisedSoFar& so_far, const Replicates& replicates,
                   std::span<const std::uint32_t> counts, const PathTracer& tracer,
                   const ExtraChannels& extra, const std::function<void()>& between_bands) {
  const std::uint64_t samples = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (so_far.samples == samples) return;
  const std::uint32_t traced = std::min(*std::ranges::min_element(counts), own_feature_samples);
  if (so_far.least != traced) {
    so_far.features =
        trace_features(tracer, *steady_tracer(tracer, *extra.scene, extra.settings), *extra.scene,
                       extra.settings, traced, extra.threads, between_bands);
    so_far.least = traced;
  }
  const Isa isa = runs_on_this_machine(extra.settings->isa) ? extra.settings->isa : Isa::automatic;
  so_far.picture = denoise::denoise(replicates, so_far.features, extra.threads, isa, between_bands);
  double& high = so_far.picture.high;
  high = std::sqrt(high * high + unseen_square(largest_radiance(*extra.scene), counts));
  so_far.samples = samples;
}

void denoise_picture(Picture& picture, const PathTracer& tracer, const ExtraChannels& extra) {
  const Replicates& replicates = picture.statistics.replicates;
  if (replicates.empty()) {
    throw RunError(
        "--denoise: the coordinator does not have the two halves of the samples: submit the job "
        "again with --denoise; if the job had that option, update the coordinator");
  }
  if (*std::ranges::min_element(picture.statistics.samples) < 2) {
    std::cerr << "parray: --denoise: a pixel has fewer than 2 samples, so the picture is not "
                 "denoised: trace more samples\n";
    return;
  }
  const SteadyClock clock;
  const Time begin = clock.now();
  DenoisedSoFar fresh;
  DenoisedSoFar& so_far = extra.denoised ? *extra.denoised : fresh;
  denoise_again(so_far, replicates, picture.statistics.samples, tracer, extra, check_interrupted);
  Denoised& denoised = so_far.picture;
  add_rgb(picture.channels, raw_channel, picture.image.rgb);
  picture.image.rgb = std::move(denoised.rgb);
  picture.report["denoised"] = {{"rmse", denoised.rmse},
                                {"low", denoised.low},
                                {"high", denoised.high},
                                {"image_sha256", image_sha256(picture.image)}};
  picture.report.at("seconds")["denoise"] = to_seconds(clock.now() - begin);
}

void add_statistics(Picture& picture, const Aovs& aovs) {
  if (aovs.contains(Aov::samples)) {
    picture.channels.push_back({samples_channel, picture.statistics.samples});
  }
  if (aovs.contains(Aov::half_width)) {
    add_rgb(picture.channels, "half_width.", picture.statistics.half_width);
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

std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id) {
  auto accelerator = extra.accelerators->find(scene_id, extra.settings);
  if (!accelerator) {
    accelerator = extra.accelerators->build(scene_id, *extra.scene, extra.settings, extra.threads);
  }
  return make_path_tracer(std::move(accelerator), extra.scene->camera, extra.settings);
}

std::optional<Image> raw_image(const ImageFile& file) {
  Image raw{file.image.width, file.image.height, std::vector<float>(file.image.rgb.size())};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto* const values = values_in<float>(file.channels, std::string(raw_channel) + "RGB"[c]);
    if (values == nullptr) return std::nullopt;
    for (std::size_t i = 0; i < values->size(); ++i) raw.rgb[3 * i + c] = (*values)[i];
  }
  return raw;
}

PictureJudge denoised_judge(ExtraChannels& extra, const std::string& scene_id) {
  return [&extra, scene_id](const FramebufferView& state) {
    if (!extra.denoised) extra.denoised = std::make_shared<DenoisedSoFar>();
    denoise_again(*extra.denoised, replicates_of(state), state.counts, *tracer_of(extra, scene_id),
                  extra, {});
    const Denoised& denoised = extra.denoised->picture;
    return ErrorFigures{.rmse = denoised.rmse, .low = denoised.low, .high = denoised.high};
  };
}

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
