#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "cli/output/picture/picture.h"
#include "common/image/image.h"

/// A map of the error: half-widths of the pixels' confidence intervals as colours.
namespace parray::output {

/// The half-widths at the ends of the colour scale, in linear radiance: 0 < low < high. Each is 1,
/// 2 or 5 times a power of ten.
struct ErrorScale {
  double low = 1e-3;
  double high = 1;

  /// Returns the place of a known half-width on the logarithmic scale: 0 for `low` and smaller, 1
  /// for `high` and larger.
  [[nodiscard]] double share_of(double half_width) const;
  /// Returns the half-width at a place from 0 to 1.
  [[nodiscard]] double at(double share) const;
};

/// Returns the largest 95 % half-width of each pixel's channels. -1: unknown, as for pixels with
/// fewer than 2 samples. Always returns `pixels` values; without statistics all are -1.
std::vector<float> half_widths_of(const PictureStatistics& statistics, std::size_t pixels);

/// Returns the scale from the first percentile to the largest of the known half-widths above 0,
/// rounded outwards. The scale spans at least a power of ten. Returns the default scale if no
/// half-width is above 0.
ErrorScale error_scale(std::vector<float> half_widths);

/// Returns the colour of a place from 0 (`low`) to 1 (`high`), linear RGB in [0, 1]:
/// ColorMap::violet_yellow.
std::array<float, 3> error_colour(double share);

/// The colour of pixels without a known half-width: white, lighter than all others.
inline constexpr std::array<float, 3> unknown_colour = {1, 1, 1};

/// Returns the size of the legend's letters below a map of `width` pixels, in pixels per em.
constexpr double error_map_letters(std::uint32_t width) {
  return std::clamp(width / 48.0, 10.0, 48.0);
}

/// Draws the map and a legend below it. `half_widths`: the result of half_widths_of() for a picture
/// of `width` pixels per row. The legend shows the colours with the half-widths at both ends and in
/// the middle, and the colour of unknown values. The result is wider than the picture if the legend
/// is. Throws RunError if the font is missing (cli/output/labels/font.h).
Image error_map(std::span<const float> half_widths, std::uint32_t width, const ErrorScale& scale);

/// Writes the map of a picture with statistics. The metadata contain the scale and the picture's
/// image_sha256. Throws Interrupted if the user stops the program, and the errors of error_map()
/// and write_image().
void write_error_map(const std::filesystem::path& file, const Picture& picture);

}  // namespace parray::output
