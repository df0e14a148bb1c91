#pragma once

#include <memory>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"
#include "cli/output/denoise/denoise.h"
#include "common/scene/scene.h"

namespace parray::tradeoff {

/// A denoised picture, and the time for tracing its features and filtering it.
struct DenoisedRender {
  Denoised picture;
  Effort effort;
};

/// Renders one scene with various settings, with `threads` > 0 threads. Not thread-safe. The scene
/// and `stop` must outlive this object.
class Bench {
 public:
  Bench(const Scene& scene, int threads, const std::atomic<bool>& stop)
      : scene_(scene), threads_(threads), stop_(stop) {}

  /// Renders the scene once. `settings` must be resolved: no value is `automatic`, except perhaps
  /// `isa`. Builds an accelerator for each combination of precision, kind and instruction set when
  /// it is first needed, outside the measured time, and keeps them all. Throws Interrupted if
  /// `stop` becomes true, or after an interrupt of the user.
  [[nodiscard]] DirectRender render(const RenderSettings& settings);

  /// Denoises `picture`, the result of render(settings). Throws InputError if a pixel has fewer
  /// than two samples, Interrupted after an interrupt of the user.
  [[nodiscard]] DenoisedRender denoise(const RenderSettings& settings, const DirectRender& picture);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] int threads() const { return threads_; }

 private:
  const std::shared_ptr<const Accelerator>& accelerator_for(const RenderSettings& settings);

  const Scene& scene_;
  const int threads_;
  std::vector<std::shared_ptr<const Accelerator>> accelerators_;
  const std::atomic<bool>& stop_;
};

}  // namespace parray::tradeoff
