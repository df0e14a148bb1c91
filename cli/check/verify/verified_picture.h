#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/check/verify/retrace.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/recipe.h"

/// A finished picture that is to be verified, and what its file says by itself.
namespace parray::verify {

/// A picture file, read.
struct VerifiedPicture {
  std::string name;  ///< for people
  ImageFile file;
  Recipe recipe;
  std::string damage{};        ///< of what the picture was made to; empty: none
  std::vector<float> alpha{};  ///< of a transparent picture

  [[nodiscard]] std::uint64_t pixels() const {
    return std::uint64_t{file.image.width} * file.image.height;
  }
  [[nodiscard]] std::array<float, 3> stored(const RetracedPixel& pixel) const {
    const std::size_t at = 3 * (std::size_t{pixel.y} * file.image.width + pixel.x);
    return {file.image.rgb[at], file.image.rgb[at + 1], file.image.rgb[at + 2]};
  }
  [[nodiscard]] bool transparent() const { return !alpha.empty(); }
  /// The name of the hash that its pixels have to have.
  [[nodiscard]] std::string hash() const {
    if (!file.high_dynamic_range) return "pixels_sha256";
    return transparent() ? "transparent:image_sha256" : "image_sha256";
  }
};

/// Reads a picture with its recipe. Throws InputError: it cannot be read, it has no recipe, or it
/// lacks what a verification needs. `traced`: its pixels are to be traced again.
VerifiedPicture read_verified_picture(const std::string& file, bool traced);

/// Why the picture cannot be the recipe's, whatever its pixels are; empty: it can.
std::string misfit_of(const VerifiedPicture& picture);
/// What else is wrong with the file by itself; empty: nothing.
std::string damage_of(const VerifiedPicture& picture);

/// Samples of each pixel, image order; empty: all have settings.samples_per_pixel. Throws
/// InputError where nobody can tell.
std::vector<std::uint32_t> sample_counts(const VerifiedPicture& picture);

/// Whether the file shows the colour, and the alpha, of a pixel that was traced again.
bool same_colour(const VerifiedPicture& picture, const RetracedPixel& pixel);

}  // namespace parray::verify
