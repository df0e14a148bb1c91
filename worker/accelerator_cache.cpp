#include "worker/accelerator_cache.h"

#include "common/scene/settings.h"

namespace parray::worker {

AcceleratorCache::Pointer AcceleratorCache::find(const std::string& scene_id,
                                                 const RenderSettings& settings) const {
  const std::scoped_lock lock(mutex_);
  return last_ && scene_id_ == scene_id && serves(*last_, settings) ? last_ : nullptr;
}

AcceleratorCache::Pointer AcceleratorCache::build(const std::string& scene_id, const Scene& scene,
                                                  const RenderSettings& settings, int threads) {
  {
    const std::scoped_lock lock(mutex_);
    last_.reset();
  }
  Pointer built =
      make_accelerator(scene, settings.precision, settings.accelerator, settings.isa, threads);
  const std::scoped_lock lock(mutex_);
  scene_id_ = scene_id;
  last_ = built;
  return built;
}

}  // namespace parray::worker
