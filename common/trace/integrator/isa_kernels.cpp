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

template <typename T>
using LanesOf = std::conditional_t<sizeof(T) == sizeof(float), FloatLanes, DoubleLanes>;
template <typename L, typename B>
using SceneTables = KernelScene<typename L::Scalar, typename B::Scalar, B::count>;
template <typename L, typename B>
using Space = Workspace<typename L::Scalar, typename B::Scalar>;

/// Calls work(wavefront) with the wavefront for the scene's features. Scenes with capsules share
/// one.
template <typename L, typename B, typename Work>
PARRAY_INLINE void with_wavefront(const SceneTables<L, B>& scene, Space<L, B>& space,
                                  const Work& work) {
  if (scene.features.capsules) {
    work(Wavefront<L, B, DoubleLanes, true, true>(scene, space));
  } else if (scene.features.sides) {
    work(Wavefront<L, B, DoubleLanes, true, false>(scene, space));
  } else {
    work(Wavefront<L, B, DoubleLanes, false, false>(scene, space));
  }
}

template <typename L, typename B>
void trace(const SceneTables<L, B>& scene, const SampleBatch& batch, PixelSums* row,
           TraceCounts& counts) {
  Space<L, B> space;
  with_wavefront<L, B>(
      scene, space, [&](auto&& wavefront) __attribute__((always_inline)) {
        wavefront.trace(batch, row, counts);
      });
}

template <typename L, typename B>
void begin(const SceneTables<L, B>& scene, const SampleBatch& batch, Space<L, B>& space) {
  with_wavefront<L, B>(
      scene,
      space, [&](auto&& wavefront) __attribute__((always_inline)) { wavefront.begin(batch); });
}

template <typename L, typename B>
void find(const SceneTables<L, B>& scene, Space<L, B>& space) {
  with_wavefront<L, B>(
      scene, space, [&](auto&& wavefront) __attribute__((always_inline)) { wavefront.find(); });
}

}  // namespace

template <typename Real, typename Store>
Kernels<Real, Store, sizeof(Store) == sizeof(float) ? float_width : double_width> kernels() {
  using L = LanesOf<Real>;
  using B = LanesOf<Store>;
  return {trace<L, B>, begin<L, B>, find<L, B>};
}
template Kernels<float, float, float_width> kernels();
template Kernels<double, float, float_width> kernels();
template Kernels<double, double, double_width> kernels();

}  // namespace parray::trace::PARRAY_ISA
