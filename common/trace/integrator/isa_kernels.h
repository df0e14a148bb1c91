#pragma once

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/kernel_scene.h"
#include "common/trace/integrator/path_columns.h"

namespace parray::trace {

/// The kernels of an instruction set for one precision.
template <typename Real, typename Store, int W>
struct Kernels {
  /// Traces a batch. Adds the samples to the pixels of their row (row[x] is the pixel in column x)
  /// and to `counts`. Only counts non-finite samples.
  void (*trace)(const KernelScene<Real, Store, W>& scene, const SampleBatch& batch, PixelSums* row,
                TraceCounts& counts);
  /// The step of trace() that makes the camera rays, `space.paths`, with the data that they need
  /// for the first surface.
  void (*begin)(const KernelScene<Real, Store, W>& scene, const SampleBatch& batch,
                Workspace<Real, Store>& space);
  /// The step of trace() that finds the next surface. For each of `space.paths` it sets t, slot,
  /// leaving and inverse_square of `space.queries`. With `features.sides`, it also reads
  /// paths.normal and paths.inside.
  void (*find)(const KernelScene<Real, Store, W>& scene, Workspace<Real, Store>& space);
};

}  // namespace parray::trace

/// Declares the kernels of each instruction set, each set in its own namespace. All are compiled
/// from isa_kernels.cpp.
#define PARRAY_DECLARE_KERNELS(isa, float_lanes, double_lanes)                                 \
  namespace parray::trace::isa {                                                               \
  inline constexpr int float_width = float_lanes;                                              \
  inline constexpr int double_width = double_lanes;                                            \
  template <typename Real, typename Store>                                                     \
  Kernels<Real, Store, sizeof(Store) == sizeof(float) ? float_width : double_width> kernels(); \
  }

PARRAY_DECLARE_KERNELS(scalar, 4, 4)
PARRAY_DECLARE_KERNELS(avx2, 8, 4)
PARRAY_DECLARE_KERNELS(avx512, 16, 8)
PARRAY_DECLARE_KERNELS(neon, 4, 4)

#undef PARRAY_DECLARE_KERNELS
