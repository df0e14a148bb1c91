#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/vec.h"

/// The sRGB transfer curve, IEC 61966-2-1.
namespace parray::picture {

/// Encodes a linear value in [0, 1] as a value in [0, 1].
inline double srgb_encode(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// Decodes an encoded value in [0, 1] to a linear value in [0, 1].
inline double srgb_decode(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// Returns the 8-bit code of a linear value: encoded, clamped to [0, 1] and rounded to nearest.
/// Returns 0 for NaN.
inline std::uint8_t srgb_byte(float linear) {
  if (!(linear > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(255 * srgb_encode(std::min(linear, 1.0F))));
}

/// Returns srgb_byte() of each value, from a table.
std::vector<std::uint8_t> srgb_bytes(std::span<const float> linear);

/// Returns the linear RGB of an 8-bit sRGB colour. Components are whole numbers from 0 to 255.
Vec3d linear_of_srgb8(const Vec3d& color);
/// Returns the same for a code 0xRRGGBB.
Vec3d linear_of_code(std::uint32_t code);

}  // namespace parray::picture
