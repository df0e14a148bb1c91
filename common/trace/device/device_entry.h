#pragma once

#include <cstdint>

#include "common/trace/device/device_job.h"
#include "common/trace/device/device_search.h"
#include "common/trace/integrator/add_sample.h"
#include "common/trace/integrator/path.h"

namespace parray::trace {

/// The kernels of a device (a GPU): K(name, Real, Store, Search, most shapes that a path can be
/// inside of).
#define PARRAY_FOR_EACH_DEVICE_KERNEL(K)                  \
  K(trace_f32_linear_0, float, float, DeviceLinear, 0)    \
  K(trace_f32_linear_8, float, float, DeviceLinear, 8)    \
  K(trace_f32_bvh_0, float, float, DeviceTree, 0)         \
  K(trace_f32_bvh_8, float, float, DeviceTree, 8)         \
  K(trace_mixed_linear_0, double, float, DeviceLinear, 0) \
  K(trace_mixed_linear_8, double, float, DeviceLinear, 8) \
  K(trace_mixed_bvh_0, double, float, DeviceTree, 0)      \
  K(trace_mixed_bvh_8, double, float, DeviceTree, 8)      \
  K(trace_f64_linear_0, double, double, DeviceLinear, 0)  \
  K(trace_f64_linear_8, double, double, DeviceLinear, 8)  \
  K(trace_f64_bvh_0, double, double, DeviceTree, 0)       \
  K(trace_f64_bvh_8, double, double, DeviceTree, 8)

/// Traces a work item: the body of a kernel. `scene_block` and `picture_block` are the blocks of
/// DeviceScene and DevicePicture. `MostInside`: most shapes that a path can be inside of. When a
/// path ends, the next one begins in the same loop, so that threads side by side do not wait for
/// each other's paths.
template <typename Real, typename Store, template <typename, typename> class Search,
          std::uint32_t MostInside>
void trace_item(const void* scene_block, const void* picture_block, const DeviceItem& item,
                DeviceSums& result) {
  const DeviceSceneView<Real, Store> scene(scene_block);
  const DevicePictureView<Real> picture(picture_block);
  const Search<Real, Store> search(scene_block);
  const RadianceScale scale = scene.head_of(scene_block).scale;
  const auto random_of = [&](std::uint32_t sample) {
    return SampleRandom(picture.head.seed, item.y * picture.head.width + item.x, sample,
                        picture.head.sampler);
  };
  InsideStack<Real, ShortList<MostInside>> sides;
  PixelSums sums;
  TraceCounts counts;
  bool overflowed = false;
  bool begins = true;
  Path<Real> path{Ray<Real>({}, {}, Real(0))};
  Vec3<Real> radiance{};
  for (std::uint32_t sample = item.begin; sample < item.end && !overflowed;) {
    const SampleRandom random = random_of(sample);
    if (begins) path = begin_path(scene, picture, item.x, item.y, random, sides);
    begins = !advance(scene, picture, search, random, path, sides, radiance, counts);
    overflowed = sides.overflowed();
    if (begins) {
      add_sample(vec_cast<double>(radiance), scale, sample++, sums, counts);
      radiance = {};
    }
  }
  result = {};
  result.handed_back = overflowed ? 1 : 0;
  if (overflowed) return;
  for (unsigned channel = 0; channel < 3; ++channel) {
    result.sum[channel] = sums.sum[channel];
    result.sum_of_squares[channel] = sums.sum_of_squares[channel];
    result.odd[channel] = sums.odd[channel];
  }
  result.rays = counts.rays;
  result.lost = counts.lost;
  result.nonfinite = static_cast<std::uint32_t>(counts.nonfinite);
}

}  // namespace parray::trace
