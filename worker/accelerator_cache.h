#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "common/scene/settings_fwd.h"
#include "common/trace/tracer.h"

namespace parray::worker {

/// Keeps the accelerator that was built last, so that the next trace of the same scene does not
/// build it again. Thread-safe.
class AcceleratorCache {
 public:
  using Pointer = std::shared_ptr<const Accelerator>;

  /// Returns the accelerator of the scene with scene_identity() `scene_id` and these settings.
  /// Returns null if the last accelerator was another one, or there is none.
  [[nodiscard]] Pointer find(const std::string& scene_id, const RenderSettings& settings) const;

  /// Drops the last accelerator and then builds a new one with `threads` threads, because two may
  /// not fit into memory. So the caller must not hold an accelerator either.
  Pointer build(const std::string& scene_id, const Scene& scene, const RenderSettings& settings,
                int threads);

 private:
  mutable std::mutex mutex_;  // guards the members below; no build holds it
  std::string scene_id_;
  Pointer last_;
};

}  // namespace parray::worker
