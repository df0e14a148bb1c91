#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/framebuffer.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

/// Renders in this process without a farm, for commands that need many pictures and the time of
/// each.
namespace parray::farm {

/// A picture, with the facts about its render.
struct DirectRender {
  /// Makes a picture without samples. `largest`: becomes largest_radiance.
  DirectRender(const RenderSettings& settings, double largest);

  [[nodiscard]] FramebufferView state() const { return framebuffer.view(largest_radiance); }
  /// Returns the mean over all pixels.
  [[nodiscard]] double samples_per_pixel() const;

  Framebuffer framebuffer;
  double largest_radiance;
  // `passes` and `stopped_by` are set when the picture is complete.
  /// Samples of each pass, of all pixels together. Empty unless settings.in_passes().
  std::vector<std::uint64_t> passes;
  StopReason stopped_by = StopReason::samples;
  double seconds = 0;           ///< wall-clock time of tracing and deciding on passes
  double cpu_seconds = 0;       ///< processor time of all threads for the same
  double deciding_seconds = 0;  ///< the part of `seconds` for deciding on passes
  double deciding_cpu_seconds = 0;
};

/// Renders the same picture as `parray render`: the same functions decide on passes. `tracer` was
/// made for `scene` and `settings`. If `stop` becomes true, returns nothing within milliseconds. If
/// settings.in_passes(), calls `after_pass`, if set, after each pass with the picture so far. The
/// time of `after_pass` also counts in DirectRender::seconds.
std::optional<DirectRender> render_directly(
    const PathTracer& tracer, const Scene& scene, const RenderSettings& settings, int threads,
    const std::atomic<bool>& stop, const std::function<void(const DirectRender&)>& after_pass = {});

/// Sets stop() when `asked` returns true. A thread of this object calls `asked` 50 times a second
/// until then.
class StopPoller {
 public:
  explicit StopPoller(std::function<bool()> asked);

  [[nodiscard]] const std::atomic<bool>& stop() const { return stop_; }

 private:
  std::atomic<bool> stop_ = false;
  std::jthread thread_;
};

}  // namespace parray::farm
