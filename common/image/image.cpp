#include "common/image/image.h"

#include <span>

#include "common/base/sha256.h"

namespace parray {

Image resolve_image(const Framebuffer& framebuffer, double largest_radiance) {
  const RadianceScale scale(largest_radiance);
  Image image{framebuffer.width(), framebuffer.height(), {}};
  image.rgb.reserve(framebuffer.pixels().size() * 3);
  for (std::size_t pixel = 0; pixel < framebuffer.pixels().size(); ++pixel) {
    const std::uint32_t count = framebuffer.samples()[pixel];
    for (const std::uint64_t sum : framebuffer.pixels()[pixel].sum) {
      image.rgb.push_back(count == 0 ? 0.0F : static_cast<float>(scale.mean(sum, count)));
    }
  }
  for (const auto& [address, excluded] : framebuffer.excluded()) {
    const auto [row, x] = address;
    const std::size_t pixel = std::size_t{row} * image.width + x;
    const std::uint32_t count = framebuffer.samples()[pixel] - excluded.count;
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
