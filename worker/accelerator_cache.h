#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "common/trace/tracer.h"

namespace parray::worker {

/// The accelerator that was built last, so that whoever traces the same scene next need not build
/// it again. Any thread.
class AcceleratorCache {
 public:
  using Pointer = std::shared_ptr<const Accelerator>;

  /// That of the scene whose scene_identity() is `scene_id`, by these settings; null if the last
  /// one was another.
  [[nodiscard]] Pointer find(const std::string& scene_id, const RenderSettings& settings) const;

  /// Builds it, after the last one was forgotten: two may not fit. The caller holds none either.
  Pointer build(const std::string& scene_id, const Scene& scene, const RenderSettings& settings,
                int threads);

 private:
  mutable std::mutex mutex_;  // guards what follows, and is not held while one is built
  std::string scene_id_;
  Pointer last_;
};

}  // namespace parray::worker
