#pragma once

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/kernel_scene.h"
#include "common/trace/integrator/path_columns.h"

/// Declares the kernels of each instruction set: the same functions, all compiled from
/// isa_kernels.cpp, each set in its own namespace.
///
/// trace() traces a batch. It adds the samples to the pixels of their row (row[x] is the pixel in
/// column x) and to `counts`. It only counts non-finite samples. begin() is the step of trace()
/// that makes the camera rays, `space.paths`, with the data that they need for the first surface.
/// find() is the step that finds the next surface. For each of `space.paths` it sets t, slot,
/// leaving and inverse_square of `space.queries`. With `features.sides`, it also reads paths.normal
/// and paths.inside.
#define PARRAY_DECLARE_KERNELS(isa, float_lanes, double_lanes)                                    \
  namespace parray::trace::isa {                                                                  \
  inline constexpr int float_width = float_lanes;                                                 \
  inline constexpr int double_width = double_lanes;                                               \
  void trace(const KernelScene<float, float, float_width>& scene, const SampleBatch& batch,       \
             PixelSums* row, TraceCounts& counts);                                                \
  void trace(const KernelScene<double, float, float_width>& scene, const SampleBatch& batch,      \
             PixelSums* row, TraceCounts& counts);                                                \
  void trace(const KernelScene<double, double, double_width>& scene, const SampleBatch& batch,    \
             PixelSums* row, TraceCounts& counts);                                                \
  void begin(const KernelScene<float, float, float_width>& scene, const SampleBatch& batch,       \
             Workspace<float, float>& space);                                                     \
  void begin(const KernelScene<double, float, float_width>& scene, const SampleBatch& batch,      \
             Workspace<double, float>& space);                                                    \
  void begin(const KernelScene<double, double, double_width>& scene, const SampleBatch& batch,    \
             Workspace<double, double>& space);                                                   \
  void find(const KernelScene<float, float, float_width>& scene, Workspace<float, float>& space); \
  void find(const KernelScene<double, float, float_width>& scene,                                 \
            Workspace<double, float>& space);                                                     \
  void find(const KernelScene<double, double, double_width>& scene,                               \
            Workspace<double, double>& space);                                                    \
  }

PARRAY_DECLARE_KERNELS(scalar, 4, 4)
PARRAY_DECLARE_KERNELS(avx2, 8, 4)
PARRAY_DECLARE_KERNELS(avx512, 16, 8)
PARRAY_DECLARE_KERNELS(neon, 4, 4)

#undef PARRAY_DECLARE_KERNELS
