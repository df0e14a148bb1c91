#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "cli/output/picture/picture.h"
#include "common/image/image.h"

/// Where a picture's error is: half-widths of its pixels as colours, for people to look at.
namespace parray::output {

/// What the ends of a map's colours stand for: half-widths in linear radiance, 0 < low < high,
/// each 1, 2 or 5 times a power of ten.
struct ErrorScale {
  double low = 1e-3;
  double high = 1;

  /// Where a half-width stands, by its logarithm: 0 at `low` and below, 1 at `high` and above.
  [[nodiscard]] double share_of(double half_width) const;
  /// The half-width that stands there.
  [[nodiscard]] double at(double share) const;
};

/// The largest 95 % half-width of each pixel's channels; -1 where it is not known, as of pixels
/// with fewer than 2 samples. `pixels` values, whatever the statistics have.
std::vector<float> half_widths_of(const PictureStatistics& statistics, std::size_t pixels);

/// From the least (but for one in a hundred) to the largest of those known and above 0, rounded
/// outwards; at least a power of ten. Where there are none, as it is by default.
ErrorScale error_scale(std::vector<float> half_widths);

/// Linear RGB in [0, 1] of a share of the way from `low` to `high`: ColorMap::violet_yellow.
std::array<float, 3> error_colour(double share);

/// Of pixels whose half-width is not known: white, which is lighter than any other.
inline constexpr std::array<float, 3> unknown_colour = {1, 1, 1};

/// Size of the legend's letters below a map that is `width` pixels wide: pixels an em.
constexpr double error_map_letters(std::uint32_t width) {
  return std::clamp(width / 48.0, 10.0, 48.0);
}

/// The map, and below it a legend: the colours from left to right with the half-widths at their
/// ends and in the middle, and the colour of what is unknown. Wider than the picture where the
/// legend is. Throws RunError when the letters' font is not there (cli/output/labels/font.h).
Image error_map(std::span<const float> half_widths, std::uint32_t width, const ErrorScale& scale);

/// Writes the map of a picture that has come with its statistics as PNG, whose text says what the
/// colours stand for and of which picture they are. Throws as write_image() does.
void write_error_map(const std::filesystem::path& file, const Picture& picture);

}  // namespace parray::output
