#include "cli/tradeoff/bench.h"

#include <utility>

#include "cli/interrupt.h"

namespace parray::tradeoff {

DirectRender Bench::render(const RenderSettings& settings) const {
  check_interrupted();
  const BuiltKernel built = build_kernel(scene_, settings, threads_);
  auto picture = render_directly(*built.kernel, scene_, settings, threads_, stop_);
  if (!picture) throw Interrupted();
  return std::move(*picture);
}

}  // namespace parray::tradeoff
