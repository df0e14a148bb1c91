#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/check/verify/retrace.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/recipe.h"

/// A finished picture to verify, and checks that need only its file.
namespace parray::verify {

/// A picture file that was read, with its recipe.
struct VerifiedPicture {
  std::string name;  ///< file name in messages
  /// The contents of the file. For a denoised picture, `image` is the picture before denoising.
  ImageFile file;
  Recipe recipe;
  /// Says which hash in the recipe is wrong: that of the denoised or of the transparent pixels of
  /// an EXR file. Empty: neither is. damage_of() compares all other hashes.
  std::string damage{};
  std::vector<float> alpha{};  ///< one per pixel; empty: opaque, or denoised

  [[nodiscard]] std::uint64_t pixels() const {
    return std::uint64_t{file.image.width} * file.image.height;
  }
  /// Returns the colour that `file.image` has at the place of `pixel`, in linear RGB.
  [[nodiscard]] std::array<float, 3> stored(const RetracedPixel& pixel) const {
    const std::size_t at = 3 * (std::size_t{pixel.y} * file.image.width + pixel.x);
    return {file.image.rgb[at], file.image.rgb[at + 1], file.image.rgb[at + 2]};
  }
  [[nodiscard]] bool transparent() const { return !alpha.empty(); }
  /// Returns the name, in the recipe, of the hash that the file's pixels must have.
  [[nodiscard]] std::string hash() const {
    if (!file.high_dynamic_range) return "pixels_sha256";
    return transparent() ? "transparent:image_sha256" : "image_sha256";
  }
};

/// Reads a picture with its recipe. `traced`: its pixels will be traced again. Throws InputError if
/// the file is unreadable, has no recipe, or lacks something that verification needs. With
/// `traced`, throws it also if postprocessing drew on the picture.
VerifiedPicture read_verified_picture(const std::string& file, bool traced);

/// Returns a channel of the file. Null: the file has none of this name.
const Channel* channel_of(const VerifiedPicture& picture, std::string_view name);

/// Compares the picture's size and total number of samples with its recipe. Returns the difference
/// as a text, or an empty text if there is none. Without the number of samples of each pixel,
/// compares only the size.
std::string misfit_of(const VerifiedPicture& picture);
/// Compares the pixels with the hash in the recipe. Returns a text that names the wrong hash, or an
/// empty text if it is right.
std::string damage_of(const VerifiedPicture& picture);

/// Returns the number of samples of each pixel, row by row. Empty: all pixels have the recipe's
/// samples_per_pixel. Throws InputError if the file does not state the numbers, or states
/// more than a pixel can have.
std::vector<std::uint32_t> sample_counts(const VerifiedPicture& picture);

/// Returns whether the file has the colour and alpha of a retraced pixel. Compares 8-bit files as
/// bytes.
bool same_colour(const VerifiedPicture& picture, const RetracedPixel& pixel);

}  // namespace parray::verify
