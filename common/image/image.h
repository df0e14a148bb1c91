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

/// Mean radiance of `count` finite samples that add up to `sums`; 0 where there are none.
std::array<float, 3> mean_radiance(const PixelSums& sums, std::uint32_t count,
                                   const RadianceScale& scale);

/// Mean radiance of every pixel over the finite samples that it holds; 0 where there are none.
Image resolve_image(const Framebuffer& framebuffer, double largest_radiance);

/// SHA-256 of the values as little-endian float32: the proof that two pictures are the same.
std::string image_sha256(const Image& image);

}  // namespace parray::image
