#pragma once

#include <memory>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"
#include "cli/output/denoise/denoise.h"
#include "common/scene/scene.h"

namespace parray::tradeoff {

/// A denoised picture, and the time of features and filter.
struct DenoisedRender {
  Denoised picture;
  Effort effort;
};

/// Renders one scene repeatedly with all threads. Not thread-safe. The scene and `stop` must
/// outlive it.
class Bench {
 public:
  Bench(const Scene& scene, int threads, const std::atomic<bool>& stop)
      : scene_(scene), threads_(threads), stop_(stop) {}

  /// `settings` must be resolved. Builds the accelerator on first use and keeps it. Throws
  /// Interrupted.
  [[nodiscard]] DirectRender render(const RenderSettings& settings);

  /// `picture` is the result of render(settings), with at least two samples per pixel. Throws
  /// Interrupted.
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
