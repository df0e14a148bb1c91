#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/check/verify/retrace.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/recipe.h"

/// A finished picture to verify, and checks that need only its file.
namespace parray::verify {

/// The contents of a picture file.
struct VerifiedPicture {
  std::string name;  ///< name in messages
  ImageFile file;
  Recipe recipe;
  std::string damage{};        ///< wrong hash of denoised or transparent pixels; empty: none
  std::vector<float> alpha{};  ///< of a transparent picture

  [[nodiscard]] std::uint64_t pixels() const {
    return std::uint64_t{file.image.width} * file.image.height;
  }
  [[nodiscard]] std::array<float, 3> stored(const RetracedPixel& pixel) const {
    const std::size_t at = 3 * (std::size_t{pixel.y} * file.image.width + pixel.x);
    return {file.image.rgb[at], file.image.rgb[at + 1], file.image.rgb[at + 2]};
  }
  [[nodiscard]] bool transparent() const { return !alpha.empty(); }
  /// Returns the name of the hash of its pixels.
  [[nodiscard]] std::string hash() const {
    if (!file.high_dynamic_range) return "pixels_sha256";
    return transparent() ? "transparent:image_sha256" : "image_sha256";
  }
};

/// Reads a picture with its recipe. `traced`: its pixels will be traced again. Throws InputError if
/// the file is unreadable, has no recipe, or lacks something that verification needs. With
/// `traced`, throws it also if postprocessing drew on the picture.
VerifiedPicture read_verified_picture(const std::string& file, bool traced);

/// Returns why the picture cannot belong to its recipe, whatever its pixels; empty: it can.
std::string misfit_of(const VerifiedPicture& picture);
/// Returns what else is wrong with the file; empty: nothing.
std::string damage_of(const VerifiedPicture& picture);

/// Returns the samples of each pixel, row by row; empty: all have settings.samples_per_pixel.
/// Throws InputError if the file does not state them, or states more than a pixel can have.
std::vector<std::uint32_t> sample_counts(const VerifiedPicture& picture);

/// Returns whether the file has the colour and alpha of a retraced pixel.
bool same_colour(const VerifiedPicture& picture, const RetracedPixel& pixel);

}  // namespace parray::verify
