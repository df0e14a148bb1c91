#include "cli/output/denoising.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/error.h"
#include "common/denoise/denoise.h"
#include "common/process/stop_signal.h"
#include "common/trace/isa.h"
#include "proto/clock.h"

namespace parray {
namespace {

void keep_raw(Picture& picture) {
  for (const std::size_t c : {0U, 1U, 2U}) {
    std::vector<float> values(picture.image.rgb.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = picture.image.rgb[3 * i + c];
    picture.channels.push_back({std::string(raw_channel) + "RGB"[c], std::move(values)});
  }
}

}  // namespace

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
        "--denoise: the coordinator has kept no halves of the samples: it is an older "
        "one, or the job was submitted without --denoise");
  }
  const std::uint32_t samples = *std::ranges::min_element(picture.statistics.samples);
  if (samples < 2) {
    std::cerr << "parray: --denoise: a pixel has less than 2 samples: the picture stays as it is\n";
    return;
  }
  const SteadyClock clock;
  const Time begin = clock.now();
  const Features features = trace_features(tracer, *extra.scene, extra.settings, samples,
                                           extra.threads, check_interrupted);
  const Isa isa = runs_on_this_machine(extra.settings.isa) ? extra.settings.isa : Isa::automatic;
  Denoised denoised = denoise(replicates, features, extra.threads, isa, check_interrupted);
  keep_raw(picture);
  picture.image.rgb = std::move(denoised.rgb);
  picture.report["denoised"] = {{"rmse", denoised.rmse},
                                {"low", denoised.low},
                                {"high", denoised.high},
                                {"image_sha256", image_sha256(picture.image)}};
  picture.report.at("seconds")["denoise"] = to_seconds(clock.now() - begin);
}

}  // namespace parray
