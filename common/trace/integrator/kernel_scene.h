#pragma once

#include <cstdint>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/ray_columns.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"

/// The data that the kernels of an instruction set read and write: plain tables, filled by
/// wavefront_tracer.cpp.
///
/// `Real` is the type of path computations, `Store` the type of stored shapes and boxes. float
/// float is precision f32, double float is mixed, double double is f64. `W` and slots: see
/// bvh_view.h.
namespace parray::trace {

/// The material of a shape in one word: its MaterialType in the low `type_bits` bits, then its
/// number in KernelScene::surfaces.
struct MaterialRef {
  static constexpr int type_bits = 2;
  static constexpr std::uint32_t type = (1U << type_bits) - 1;  ///< mask of the type
};

/// The features of a scene. The kernel leaves out features that the scene does not have.
struct KernelFeatures {
  bool sides = true;     ///< a path can be inside a shape: there is glass, or a shape at the lens
  bool fuzz = true;      ///< some metal is not a perfect mirror
  bool capsules = true;  ///< there are capsules
};

/// StartShapes in the form that kernels use.
struct StartTable {
  const std::uint32_t* numbers = nullptr;  ///< slots, grouped by tile; null: none
  const std::uint32_t* begins = nullptr;   ///< index of each tile's first number, then the total
  std::uint32_t bits = 0;                  ///< a tile has 2^bits pixels a side
  std::uint32_t across = 1;                ///< tiles in a row of them

  /// Returns the number of the tile that contains pixel (x, y).
  [[nodiscard]] PARRAY_INLINE std::uint32_t tile(std::uint32_t x, std::uint32_t y) const {
    return (y >> bits) * across + (x >> bits);
  }
};

/// The scene and the picture.
template <typename Real, typename Store, int W>
struct KernelScene {
  KernelScene(const CameraRays<Real>& v, const SkyGradient<Real>& s) : view(v), sky(s) {}

  CameraRays<Real> view;
  SkyGradient<Real> sky;
  std::uint32_t width = 0;  ///< width of the picture in pixels
  std::uint32_t max_depth = 1;
  std::uint64_t seed = 0;
  Sampler sampler = Sampler::independent;
  double to_fixed = 1;  ///< RadianceScale::factor()
  KernelFeatures features;

  BvhView<Store, W> bvh;                               ///< the spheres
  const MaterialParameters<Real>* surfaces = nullptr;  ///< by material
  /// MaterialRef of each slot, starting at bit material_bit.
  const std::uint32_t* material_of = nullptr;
  int material_bit = 0;                      ///< first bit of the MaterialRef
  StartTable start;                          ///< slots of shapes that paths may begin inside of
  BvhView<Store, W, CapsuleBlock> capsules;  ///< empty if the scene has none

  /// Returns the capsule in a slot, which is capsules.first_slot or higher.
  [[nodiscard]] PARRAY_INLINE CapsuleShape<Real> capsule_at(std::uint32_t slot) const {
    return shape_at<Real>(capsules.blocks, slot - capsules.first_slot);
  }
};

/// Samples of one row of the picture.
struct SampleBatch {
  static constexpr std::uint32_t most = most_rays;

  std::uint32_t y = 0;
  std::uint32_t count = 0;                             ///< 1 .. most
  alignas(64) std::uint32_t column[column_size] = {};  ///< x of each sample
  alignas(64) std::uint32_t sample[column_size] = {};  ///< number of each sample within its pixel
};

/// Radiance of each sample of a batch: red, green, blue and 0. Each is a fixed-point number of
/// RadianceScale in the form that RadianceScale::fixed_of() takes. A non-finite value is NaN.
struct BatchRadiance {
  alignas(64) double of[SampleBatch::most][4];
};

}  // namespace parray::trace
