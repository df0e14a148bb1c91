#include "cli/output/denoising.h"

#include <algorithm>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "common/adaptive/replicates.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "proto/clock.h"

namespace parray::output {
namespace {

void keep_raw(Picture& picture) {
  for (const std::size_t c : {0U, 1U, 2U}) {
    std::vector<float> values(picture.image.rgb.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = picture.image.rgb[3 * i + c];
    picture.channels.push_back({std::string(raw_channel) + "RGB"[c], std::move(values)});
  }
}

std::uint64_t samples_of(std::span<const std::uint32_t> counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

/// Updates `so_far` to a picture with `samples` samples in total and at least `least` per pixel.
void denoise_again(DenoisedSoFar& so_far, const Replicates& replicates, const PathTracer& tracer,
                   const ExtraChannels& extra, std::uint32_t least, std::uint64_t samples,
                   const std::function<void()>& between_bands) {
  if (so_far.samples == samples) return;
  const std::uint32_t traced = std::min(least, own_feature_samples);
  if (so_far.least != traced) {
    so_far.features =
        trace_features(tracer, *extra.scene, extra.settings, traced, extra.threads, between_bands);
    so_far.least = traced;
  }
  const Isa isa = runs_on_this_machine(extra.settings->isa) ? extra.settings->isa : Isa::automatic;
  so_far.picture = denoise::denoise(replicates, so_far.features, extra.threads, isa, between_bands);
  so_far.samples = samples;
}

}  // namespace

PictureJudge denoised_judge(ExtraChannels& extra, const std::string& scene_id) {
  return [&extra, scene_id](const FramebufferView& state) {
    if (!extra.denoised) extra.denoised = std::make_shared<DenoisedSoFar>();
    const std::uint32_t least = *std::ranges::min_element(state.counts);
    denoise_again(*extra.denoised, replicates_of(state), *tracer_of(extra, scene_id), extra, least,
                  samples_of(state.counts), {});
    const Denoised& denoised = extra.denoised->picture;
    ErrorFigures error;
    error.rmse = denoised.rmse;
    error.low = denoised.low;
    error.high = denoised.high;
    return error;
  };
}

std::optional<Image> raw_image(const ImageFile& file) {
  Image raw{file.image.width, file.image.height, std::vector<float>(file.image.rgb.size())};
  std::size_t found = 0;
  for (const Channel& channel : file.channels) {
    for (const std::size_t c : {0U, 1U, 2U}) {
      const auto* const values = std::get_if<std::vector<float>>(&channel.values);
      if (values == nullptr || channel.name != std::string(raw_channel) + "RGB"[c]) continue;
      for (std::size_t i = 0; i < values->size(); ++i) raw.rgb[3 * i + c] = (*values)[i];
      ++found;
    }
  }
  return found == 3 ? std::optional(std::move(raw)) : std::nullopt;
}

void denoise_picture(Picture& picture, const PathTracer& tracer, const ExtraChannels& extra) {
  const Replicates& replicates = picture.statistics.replicates;
  if (replicates.empty()) {
    throw RunError(
        "--denoise: the coordinator does not have the two halves of the samples: submit the job "
        "again with --denoise; if the job had that option, update the coordinator");
  }
  const std::uint32_t least = *std::ranges::min_element(picture.statistics.samples);
  if (least < 2) {
    std::cerr << "parray: --denoise: a pixel has fewer than 2 samples, so the picture is not "
                 "denoised: trace more samples\n";
    return;
  }
  const SteadyClock clock;
  const Time begin = clock.now();
  DenoisedSoFar fresh;
  DenoisedSoFar& so_far = extra.denoised ? *extra.denoised : fresh;
  const std::uint64_t samples = samples_of(picture.statistics.samples);
  denoise_again(so_far, replicates, tracer, extra, least, samples, check_interrupted);
  Denoised& denoised = so_far.picture;
  keep_raw(picture);
  picture.image.rgb = std::move(denoised.rgb);
  picture.report["denoised"] = {{"rmse", denoised.rmse},
                                {"low", denoised.low},
                                {"high", denoised.high},
                                {"image_sha256", image_sha256(picture.image)}};
  picture.report.at("seconds")["denoise"] = to_seconds(clock.now() - begin);
}

}  // namespace parray::output
