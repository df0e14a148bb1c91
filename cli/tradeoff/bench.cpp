#include "cli/tradeoff/bench.h"

#include <utility>

#include "common/process/stop_signal.h"
#include "common/trace/tracer.h"

namespace parray::tradeoff {

const std::shared_ptr<const Accelerator>& Bench::accelerator_for(const RenderSettings& settings) {
  for (const auto& accelerator : accelerators_) {
    if (serves(*accelerator, settings)) return accelerator;
  }
  return accelerators_.emplace_back(
      make_accelerator(scene_, settings.precision, settings.accelerator, settings.isa, {threads_}));
}

DirectRender Bench::render(const RenderSettings& settings) {
  check_interrupted();
  const auto tracer = make_path_tracer(accelerator_for(settings), scene_.camera, settings);
  auto picture = render_directly(*tracer, scene_, settings, threads_, stop_);
  if (!picture) throw Interrupted();
  return std::move(*picture);
}

}  // namespace parray::tradeoff
