/// The build compiles this file once for each instruction set. PARRAY_ISA names the set,
/// PARRAY_LANES names the header of its lanes, and the compiler's flags allow the set. No function
/// that other files share may be compiled out of line here: see inline.h.
#include "common/trace/integrator/isa_kernels.h"

#include "common/trace/integrator/wavefront.h"
#include PARRAY_LANES

namespace parray::trace::PARRAY_ISA {
namespace {

using math::PARRAY_ISA::DoubleLanes;
using math::PARRAY_ISA::FloatLanes;

/// Calls work(wavefront) with the wavefront for the scene's features. Scenes with capsules share
/// one.
template <typename L, typename B, typename SceneTables, typename Space, typename Work>
PARRAY_INLINE void with_wavefront(const SceneTables& scene, Space& space, const Work& work) {
  if (scene.features.capsules) {
    work(Wavefront<L, B, DoubleLanes, true, true>(scene, space));
  } else if (scene.features.sides) {
    work(Wavefront<L, B, DoubleLanes, true, false>(scene, space));
  } else {
    work(Wavefront<L, B, DoubleLanes, false, false>(scene, space));
  }
}

template <typename L, typename B, typename SceneTables>
PARRAY_INLINE void trace_batch(const SceneTables& scene, const SampleBatch& batch, PixelSums* row,
                               TraceCounts& counts) {
  Workspace<typename L::Scalar, typename B::Scalar> space;
  with_wavefront<L, B>(
      scene, space, [&](auto&& wavefront) __attribute__((always_inline)) {
        wavefront.trace(batch, row, counts);
      });
}

template <typename L, typename B, typename SceneTables, typename Space>
PARRAY_INLINE void begin_batch(const SceneTables& scene, const SampleBatch& batch, Space& space) {
  with_wavefront<L, B>(
      scene,
      space, [&](auto&& wavefront) __attribute__((always_inline)) { wavefront.begin(batch); });
}

template <typename L, typename B, typename SceneTables, typename Space>
PARRAY_INLINE void find_all(const SceneTables& scene, Space& space) {
  with_wavefront<L, B>(
      scene, space, [&](auto&& wavefront) __attribute__((always_inline)) { wavefront.find(); });
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

}  // namespace parray::trace::PARRAY_ISA
