#pragma once

#include <set>
#include <string>
#include <string_view>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Radii by a number of the particles. By default, there are none.
struct RadiusScale {
  std::string by;   ///< name of the number; empty: none
  double low = 0;   ///< radius of the least number, in ranges::length; 0: the number is the radius
  double high = 0;  ///< radius of the largest number, above `low`; 0: the number is the radius
  /// Numbers that get `low` and `high`: those of all frames. Empty: those of the particles. Scene
  /// files do not contain them.
  NumberBounds numbers{};

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const RadiusScale&, const RadiusScale&) = default;
};

/// Parses COLUMN or COLUMN:LOW:HIGH. Throws InputError, which names no place, for other texts.
RadiusScale radius_scale_from(std::string_view text);
/// Returns the text that radius_scale_from() parses to `scale`. Returns "" if there are no radii.
std::string text_of(const RadiusScale& scale);

/// Returns the numeric columns of the file that the radii need.
std::set<std::string, std::less<>> numbers_of(const RadiusScale& scale);

/// Sets the radii of `particles`. With LOW and HIGH, a radius is a linear function of the number.
/// If all numbers are equal, the radius is the mean of LOW and HIGH. Returns the numbers that got
/// LOW and HIGH; none without LOW and HIGH.
///
/// Throws UnknownNumber. Throws SourceError("radius_by") for a number that is not known and for a
/// radius outside ranges::length.
NumberBounds apply(const RadiusScale& scale, Particles& particles);

}  // namespace parray::input
