#pragma once

#include "cli/direct_render.h"
#include "common/scene/scene.h"

namespace parray::tradeoff {

/// Renders one scene over and over with all threads. The scene and `stop` must outlive it.
class Bench {
 public:
  Bench(const Scene& scene, int threads, const std::atomic<bool>& stop)
      : scene_(scene), threads_(threads), stop_(stop) {}

  /// `settings` are resolved. Throws Interrupted.
  [[nodiscard]] DirectRender render(const RenderSettings& settings) const;

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] int threads() const { return threads_; }

 private:
  const Scene& scene_;
  const int threads_;
  const std::atomic<bool>& stop_;
};

}  // namespace parray::tradeoff
