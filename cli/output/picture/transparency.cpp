#include "cli/output/picture/transparency.h"

#include <algorithm>
#include <cmath>

#include "cli/output/picture/srgb.h"
#include "common/base/sha256.h"
#include "common/image/lattice.h"

namespace parray::picture {
namespace {

std::uint8_t alpha_byte(float alpha) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(alpha, 0.0F, 1.0F)));
}

}  // namespace

std::span<const float> alpha_of(const Channels& channels) {
  const auto* const values = values_in<float>(channels, alpha_channel);
  return values == nullptr ? std::span<const float>() : *values;
}

TransparentPixel without_sky(const std::array<float, 3>& mean, const SkySamples& sky,
                             std::uint32_t samples, const RadianceScale& scale) {
  if (sky.count >= samples) return {};
  TransparentPixel pixel;
  for (std::size_t c = 0; c < 3; ++c) {
    const double rest = static_cast<double>(mean[c]) - scale.mean(sky.sum[c], samples);
    pixel.colour[c] = static_cast<float>(std::max(rest, 0.0));
  }
  pixel.alpha = static_cast<float>(static_cast<double>(samples - sky.count) / samples);
  return pixel;
}

std::vector<float> remove_sky(Image& image, std::span<const SkySamples> sky,
                              std::span<const std::uint32_t> samples, const RadianceScale& scale) {
  std::vector<float> alpha(samples.size());
  for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel) {
    std::size_t source = pixel;
    if (samples[pixel] == 0) {
      const BlockCorner corner =
          block_corner(samples, image.width, static_cast<std::uint32_t>(pixel % image.width),
                       static_cast<std::uint32_t>(pixel / image.width));
      source = std::size_t{corner.y} * image.width + corner.x;
    }
    float* const rgb = &image.rgb[3 * pixel];
    const TransparentPixel out =
        without_sky({rgb[0], rgb[1], rgb[2]}, sky[source], samples[source], scale);
    std::ranges::copy(out.colour, rgb);
    alpha[pixel] = out.alpha;
  }
  return alpha;
}

void put_on_background(Image& image, std::vector<float>& alpha, const Vec3d& color) {
  const std::array<double, 3> channels{color.x, color.y, color.z};
  for (std::size_t i = 0; i < image.rgb.size() && !alpha.empty(); ++i) {
    const auto free = 1 - static_cast<double>(alpha[i / 3]);
    image.rgb[i] = static_cast<float>(static_cast<double>(image.rgb[i]) + free * channels[i % 3]);
  }
  alpha.clear();
}

std::string transparent_sha256(const Image& image, std::span<const float> alpha) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(image.rgb)));
  hash.add(std::as_bytes(alpha));
  return hash.hex();
}

std::vector<std::uint8_t> transparent_bytes(std::span<const float> rgb,
                                            std::span<const float> alpha) {
  std::vector<float> colours(rgb.begin(), rgb.end());
  for (std::size_t i = 0; i < colours.size(); ++i) colours[i] /= alpha[i / 3];
  const std::vector<std::uint8_t> codes = srgb_bytes(colours);
  std::vector<std::uint8_t> bytes(4 * alpha.size());
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    const std::uint8_t code = alpha_byte(alpha[i]);
    if (code == 0) continue;
    std::copy_n(&codes[3 * i], 3, &bytes[4 * i]);
    bytes[4 * i + 3] = code;
  }
  return bytes;
}

std::vector<std::uint8_t> png_bytes(const Image& image, const Channels& channels) {
  const std::span<const float> alpha = alpha_of(channels);
  return alpha.empty() ? srgb_bytes(image.rgb) : transparent_bytes(image.rgb, alpha);
}

}  // namespace parray::picture
