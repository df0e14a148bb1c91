#pragma once

#include <cstdint>

#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"
#include "common/math/vec.h"

namespace parray::trace {

/// Adds sample number `sample` to a pixel and to `counts`. `shifted` is its radiance (R, G, B) in
/// the form that RadianceScale::fixed_of() takes. If one number is NaN, because the radiance is not
/// finite, the function only counts the sample, also as non-finite.
inline void add_fixed(const Vec3d& shifted, std::uint32_t sample, PixelSums& pixel,
                      TraceCounts& counts) {
  ++counts.samples;
  if (const double sum = shifted.x + shifted.y + shifted.z; sum != sum) {
    ++counts.nonfinite;
    return;
  }
  pixel.add({RadianceScale::fixed_of(shifted.x), RadianceScale::fixed_of(shifted.y),
             RadianceScale::fixed_of(shifted.z)},
            sample);
}

/// Does the same as add_fixed(), from a radiance.
inline void add_sample(const Vec3d& radiance, const RadianceScale& scale, std::uint32_t sample,
                       PixelSums& pixel, TraceCounts& counts) {
  // x - x is 0 for finite x alone.
  const auto shifted = [&scale](double value) {
    return static_cast<double>(scale.to_fixed(value)) + RadianceScale::shift + (value - value);
  };
  add_fixed({shifted(radiance.x), shifted(radiance.y), shifted(radiance.z)}, sample, pixel, counts);
}

}  // namespace parray::trace
