#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cli/output/picture/channels.h"
#include "common/image/image.h"
#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"

/// Pictures without their background. Alpha of a pixel is the share of its camera rays that meet
/// something, and its colour is premultiplied: what the samples of these rays add to its mean
/// (Porter and Duff, "Compositing digital images", SIGGRAPH 1984; the convention of OpenEXR).
namespace parray::picture {

/// The channel that holds alpha, as EXR has it.
inline constexpr const char* alpha_channel = "A";

/// That channel's values; empty: the picture has its background.
std::span<const float> alpha_of(const Channels& channels);

/// Colour, premultiplied, and alpha.
struct TransparentPixel {
  std::array<float, 3> colour{};
  float alpha = 0;
};

/// A pixel of mean radiance `mean`, over `samples` > 0 samples, without its background: exactly 0
/// where there is nothing else, never negative.
TransparentPixel without_sky(const std::array<float, 3>& mean, const SkySamples& sky,
                             std::uint32_t samples, const RadianceScale& scale);

/// The same of a picture; returns alpha. `sky` and `samples` are of each pixel, image order; one
/// without a sample shows its block's corner (lattice.h) and has that one's background.
std::vector<float> take_out_sky(Image& image, std::span<const SkySamples> sky,
                                std::span<const std::uint32_t> samples, const RadianceScale& scale);

/// SHA-256 of a transparent picture: its premultiplied colours, top row first, then alpha, as
/// little-endian float32.
std::string transparent_sha256(const Image& image, std::span<const float> alpha);

/// 8-bit codes of a transparent picture as PNG has them, red, green, blue, alpha: the colours
/// divided by alpha (unassociated), with the sRGB curve; all 0 where alpha's code is. The same
/// again from what read_image() makes of them.
std::vector<std::uint8_t> transparent_bytes(std::span<const float> rgb,
                                            std::span<const float> alpha);

/// The codes that a PNG file of a picture has: transparent_bytes() if `channels` has alpha, or else
/// srgb_bytes().
std::vector<std::uint8_t> png_bytes(const Image& image, const Channels& channels);

}  // namespace parray::picture
