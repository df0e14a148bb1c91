#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/framebuffer.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path_tracer.h"

/// Renders in this process, without a farm: for commands that need many pictures, and how long each
/// took.
namespace parray::farm {

/// A picture that is complete.
struct DirectRender {
  DirectRender(const RenderSettings& settings, double largest)
      : framebuffer(settings.width, settings.height), largest_radiance(largest) {}

  [[nodiscard]] FramebufferView state() const { return framebuffer.view(largest_radiance); }
  [[nodiscard]] double samples_per_pixel() const;

  Framebuffer framebuffer;
  double largest_radiance;
  std::vector<std::uint64_t> passes;  ///< samples of each; empty unless settings.in_passes()
  StopReason stopped_by = StopReason::samples;
  double seconds = 0;           ///< of tracing and deciding on passes, by the clock on the wall
  double cpu_seconds = 0;       ///< the same of all threads together
  double deciding_seconds = 0;  ///< of those, deciding on passes
  double deciding_cpu_seconds = 0;
};

/// The very picture that `parray render` makes: passes are decided by the same functions. `tracer`
/// was made for `scene` and `settings`. None if `stop` was set meanwhile, within milliseconds.
/// `after_pass` is called with what there is so far; its time counts for the passes, too.
std::optional<DirectRender> render_directly(
    const PathTracer& tracer, const Scene& scene, const RenderSettings& settings, int threads,
    const std::atomic<bool>& stop, const std::function<void(const DirectRender&)>& after_pass = {});

/// Sets stop() when `asked` says so, which is called from a thread of its own 50 times a second.
class StopWatch {
 public:
  explicit StopWatch(std::function<bool()> asked);

  [[nodiscard]] const std::atomic<bool>& stop() const { return stop_; }

 private:
  std::atomic<bool> stop_ = false;
  std::jthread thread_;
};

}  // namespace parray::farm
