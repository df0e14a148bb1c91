#include "common/image/image.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "common/base/sha256.h"

namespace parray::image {

std::array<float, 3> mean_radiance(const PixelSums& sums, std::uint32_t count,
                                   const RadianceScale& scale) {
  std::array<float, 3> mean{};
  for (std::size_t channel = 0; count > 0 && channel < 3; ++channel) {
    mean[channel] = static_cast<float>(scale.mean(sums.sum[channel], count));
  }
  return mean;
}

Image resolve_image(const Framebuffer& framebuffer, double largest_radiance) {
  const RadianceScale scale(largest_radiance);
  Image image{framebuffer.width(), framebuffer.height(), {}};
  image.rgb.reserve(framebuffer.pixels().size() * 3);
  for (std::size_t pixel = 0; pixel < framebuffer.pixels().size(); ++pixel) {
    const auto mean =
        mean_radiance(framebuffer.pixels()[pixel], framebuffer.samples()[pixel], scale);
    image.rgb.insert(image.rgb.end(), mean.begin(), mean.end());
  }
  for (const auto& [address, excluded] : framebuffer.excluded()) {
    const auto [row, x] = address;
    const std::size_t pixel = std::size_t{row} * image.width + x;
    const std::uint32_t count = framebuffer.samples()[pixel] - excluded.count;
    const auto mean = mean_radiance(framebuffer.pixels()[pixel], count, scale);
    std::ranges::copy(mean, image.rgb.begin() + static_cast<std::ptrdiff_t>(pixel) * 3);
  }
  return image;
}

std::string image_sha256(const Image& image) {
  return sha256_hex(std::as_bytes(std::span(image.rgb)));
}

}  // namespace parray::image
