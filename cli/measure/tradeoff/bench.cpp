#include "cli/measure/tradeoff/bench.h"

#include <algorithm>
#include <utility>

#include "common/adaptive/replicates.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"

namespace parray::tradeoff {

const std::shared_ptr<const Accelerator>& Bench::accelerator_for(const RenderSettings& settings) {
  for (const auto& accelerator : accelerators_) {
    if (serves(*accelerator, settings)) return accelerator;
  }
  return accelerators_.emplace_back(
      make_accelerator(scene_, settings.precision, settings.accelerator, settings.isa, threads_));
}

DirectRender Bench::render(const RenderSettings& settings) {
  check_interrupted();
  const auto tracer = make_path_tracer(accelerator_for(settings), scene_.camera, settings);
  auto picture = render_directly(*tracer, scene_, settings, threads_, stop_);
  if (!picture) throw Interrupted();
  return std::move(*picture);
}

DenoisedRender Bench::denoise(const RenderSettings& settings, const DirectRender& picture) {
  const FramebufferView state = picture.state();
  const std::uint32_t samples = *std::ranges::min_element(state.counts);
  if (samples < 2) {
    throw InputError("--denoise needs at least two samples per pixel: use --spp 2 or more");
  }
  const auto tracer = make_path_tracer(accelerator_for(settings), scene_.camera, settings);
  const Effort began = effort_now();
  const Features features =
      trace_features(*tracer, scene_, settings, samples, threads_, check_interrupted);
  Denoised denoised =
      denoise::denoise(replicates_of(state), features, threads_, settings.isa, check_interrupted);
  return {std::move(denoised), effort_now() - began};
}

}  // namespace parray::tradeoff
