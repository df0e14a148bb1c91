#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/image/framebuffer.h"

namespace parray::image {

/// Linear RGB in single precision, top row first: width * height * 3 values.
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<float> rgb;
};

/// Returns the mean radiance (R, G, B) of `count` finite samples with the sums `sums`; 0 if `count`
/// is 0.
std::array<float, 3> mean_radiance(const PixelSums& sums, std::uint32_t count,
                                   const RadianceScale& scale);

/// Computes the mean radiance of every pixel over its finite samples; 0 for a pixel without any.
/// `largest_radiance`: that of the scene whose sums the framebuffer holds.
Image resolve_image(const Framebuffer& framebuffer, double largest_radiance);

/// Returns the SHA-256 of `image.rgb` as little-endian float32. Equal hashes prove that two
/// pictures of the same size are the same.
std::string image_sha256(const Image& image);

}  // namespace parray::image
