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
#include "common/math/vec.h"

/// Pictures without their background. Alpha of a pixel is the share of its camera rays that hit a
/// shape. Its colour is premultiplied: the contribution of these rays to the mean (Porter and
/// Duff, "Compositing digital images", SIGGRAPH 1984; the convention of OpenEXR).
namespace parray::picture {

/// The channel of alpha in EXR files.
inline constexpr const char* alpha_channel = "A";

/// Returns the values of that channel, which are valid as long as `channels` is unchanged. Empty:
/// the picture has its background.
std::span<const float> alpha_of(const Channels& channels);

/// Premultiplied colour and alpha.
struct TransparentPixel {
  std::array<float, 3> colour{};
  float alpha = 0;
};

/// Removes the background from a pixel with mean radiance `mean` over `samples` > 0 samples. `sky`
/// has the number of samples whose camera rays hit nothing, and the sum of their radiance. The
/// result is exactly 0 for pixels that show only background, and never negative.
TransparentPixel without_sky(const std::array<float, 3>& mean, const SkySamples& sky,
                             std::uint32_t samples, const RadianceScale& scale);

/// Removes the background from a picture and returns alpha, one value per pixel. `sky` (from
/// trace_sky_samples()) and `samples` have an entry for each pixel, in image order. `scale`:
/// RadianceScale of the scene's largest_radiance(). A pixel without a sample shows the corner of
/// its block (lattice.h) and uses the corner's background.
std::vector<float> remove_sky(Image& image, std::span<const SkySamples> sky,
                              std::span<const std::uint32_t> samples, const RadianceScale& scale);

/// Puts a transparent picture on a background of one colour, linear RGB. Clears `alpha`.
void put_on_background(Image& image, std::vector<float>& alpha, const Vec3d& color);

/// Returns the SHA-256 of a transparent picture, 64 hexadecimal digits: the premultiplied colours
/// of all pixels, top row first, then alpha of all pixels, as little-endian float32.
std::string transparent_sha256(const Image& image, std::span<const float> alpha);

/// Returns the 8-bit codes of a transparent picture for PNG, in the order red, green, blue, alpha.
/// Divides colours by alpha (unassociated) and encodes them with sRGB. All codes are 0 where the
/// code of alpha is 0. A picture that read_image() reads from such a file gives the same codes
/// again.
std::vector<std::uint8_t> transparent_bytes(std::span<const float> rgb,
                                            std::span<const float> alpha);

/// Returns the codes in a PNG file of a picture: transparent_bytes() if `channels` has alpha,
/// otherwise srgb_bytes().
std::vector<std::uint8_t> png_bytes(const Image& image, const Channels& channels);

}  // namespace parray::picture
