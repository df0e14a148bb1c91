#include "common/image/image.h"

#include <span>

#include "common/base/sha256.h"

namespace parray {

Image resolve_image(const Framebuffer& framebuffer, double largest_radiance) {
  const RadianceScale scale(largest_radiance);
  Image image{framebuffer.width(), framebuffer.height(), {}};
  image.rgb.reserve(framebuffer.pixels().size() * 3);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint32_t count = framebuffer.samples_in_row(y);
    const PixelSums* row = framebuffer.pixels().data() + std::size_t{y} * image.width;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      for (const std::uint64_t sum : row[x].sum) {
        image.rgb.push_back(count == 0 ? 0.0F : static_cast<float>(scale.mean(sum, count)));
      }
    }
  }
  for (const auto& [address, excluded] : framebuffer.excluded()) {
    const auto [row, x] = address;
    const std::uint32_t count = framebuffer.samples_in_row(row) - excluded.count;
    const std::size_t pixel = std::size_t{row} * image.width + x;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::uint64_t sum = framebuffer.pixels()[pixel].sum[channel];
      image.rgb[pixel * 3 + channel] =
          count == 0 ? 0.0F : static_cast<float>(scale.mean(sum, count));
    }
  }
  return image;
}

std::string image_sha256(const Image& image) {
  return sha256_hex(std::as_bytes(std::span(image.rgb)));
}

}  // namespace parray
