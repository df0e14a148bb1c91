/// Compiled once for each instruction set, with PARRAY_ISA naming it and the compiler's flags
/// allowing it. Nothing that other files share may be left out of line here: see inline.h.
#include "common/trace/integrator/isa_kernels.h"

#include "common/trace/integrator/wavefront.h"

#if defined(__AVX512F__)
#include "common/math/lanes_avx512.h"
namespace parray::avx512 {
using FloatLanes = Float16;
using DoubleLanes = Double8;
}  // namespace parray::avx512
#elif defined(__AVX2__)
#include "common/math/lanes_avx2.h"
namespace parray::avx2 {
using FloatLanes = Float8;
using DoubleLanes = Double4;
}  // namespace parray::avx2
#else
namespace parray::scalar {
using FloatLanes = Lanes<float, float_width>;
using DoubleLanes = Lanes<double, double_width>;
}  // namespace parray::scalar
#endif

namespace parray::PARRAY_ISA {
namespace {

template <typename L, typename B, typename SceneTables>
PARRAY_INLINE void trace_batch(const SceneTables& scene, const SampleBatch& batch, PixelSums* row,
                               TraceCounts& counts) {
  Workspace<typename L::Scalar, typename B::Scalar> space;
  if (scene.features.sides) {
    Wavefront<L, B, DoubleLanes, true>(scene, space).trace(batch, row, counts);
  } else {
    Wavefront<L, B, DoubleLanes, false>(scene, space).trace(batch, row, counts);
  }
}

template <typename L, typename B, typename SceneTables, typename Space>
PARRAY_INLINE void begin_batch(const SceneTables& scene, const SampleBatch& batch, Space& space) {
  if (scene.features.sides) {
    Wavefront<L, B, DoubleLanes, true>(scene, space).begin(batch);
  } else {
    Wavefront<L, B, DoubleLanes, false>(scene, space).begin(batch);
  }
}

template <typename L, typename B, typename SceneTables, typename Space>
PARRAY_INLINE void find_all(const SceneTables& scene, Space& space) {
  Traversal<L, B> traversal(scene.bvh, space.paths, space);
  if (scene.features.sides) {
    traversal.template find_all<true>();
  } else {
    traversal.template find_all<false>();
  }
}

}  // namespace

void trace(const KernelScene<float, float, float_width>& scene, const SampleBatch& batch,
           PixelSums* row, TraceCounts& counts) {
  trace_batch<FloatLanes, FloatLanes>(scene, batch, row, counts);
}
void trace(const KernelScene<double, float, float_width>& scene, const SampleBatch& batch,
           PixelSums* row, TraceCounts& counts) {
  trace_batch<DoubleLanes, FloatLanes>(scene, batch, row, counts);
}
void trace(const KernelScene<double, double, double_width>& scene, const SampleBatch& batch,
           PixelSums* row, TraceCounts& counts) {
  trace_batch<DoubleLanes, DoubleLanes>(scene, batch, row, counts);
}

void begin(const KernelScene<float, float, float_width>& scene, const SampleBatch& batch,
           Workspace<float, float>& space) {
  begin_batch<FloatLanes, FloatLanes>(scene, batch, space);
}
void begin(const KernelScene<double, float, float_width>& scene, const SampleBatch& batch,
           Workspace<double, float>& space) {
  begin_batch<DoubleLanes, FloatLanes>(scene, batch, space);
}
void begin(const KernelScene<double, double, double_width>& scene, const SampleBatch& batch,
           Workspace<double, double>& space) {
  begin_batch<DoubleLanes, DoubleLanes>(scene, batch, space);
}

void find(const KernelScene<float, float, float_width>& scene, Workspace<float, float>& space) {
  find_all<FloatLanes, FloatLanes>(scene, space);
}
void find(const KernelScene<double, float, float_width>& scene, Workspace<double, float>& space) {
  find_all<DoubleLanes, FloatLanes>(scene, space);
}
void find(const KernelScene<double, double, double_width>& scene,
          Workspace<double, double>& space) {
  find_all<DoubleLanes, DoubleLanes>(scene, space);
}

}  // namespace parray::PARRAY_ISA
