#pragma once

#include <cstdint>

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/kernel_scene.h"
#include "common/trace/integrator/path_columns.h"

/// What each instruction set offers: the same functions, from the one source isa_kernels.cpp, in a
/// namespace of its own.
///
/// trace() traces a batch and adds its samples to the pixels of its row, by column, and to
/// `counts`; those that are not finite are counted alone. begin() is the step of it that makes the
/// camera rays, `space.paths`, with what these need for the first surface. find() is the step of it
/// that finds the next surface: for each of `space.paths` it sets t, slot and leaving of
/// `space.queries`; with `features.sides`, paths.normal and paths.inside count too.
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
