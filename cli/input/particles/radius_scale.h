#pragma once

#include <string>
#include <string_view>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// A rule that makes radii from a number of each particle, such as its mass. By default, there is
/// no rule.
struct RadiusScale {
  std::string by;   ///< name of the number; empty: none
  double low = 0;   ///< radius of the least number, in ranges::length; 0: the number is the radius
  double high = 0;  ///< radius of the largest number, above `low`; 0 if `low` is 0
  /// Numbers that get `low` and `high`: those of all frames. Empty: those of the particles. Scene
  /// files do not contain them.
  NumberBounds numbers{};

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const RadiusScale&, const RadiusScale&) = default;
};

/// Parses COLUMN or COLUMN:LOW:HIGH. COLUMN may contain a colon: velocity:0. Throws InputError,
/// which names no place, for other texts.
RadiusScale radius_scale_from(std::string_view text);
/// Returns the text that radius_scale_from() parses to `scale`. Returns "" if there are no radii.
std::string text_of(const RadiusScale& scale);

/// Sets the radii of `particles`. With `low` and `high`, a radius is a linear function of the
/// number, between `low` and `high`. If all numbers are equal, the radius is the mean of `low` and
/// `high`. Returns the numbers whose radii are `low` and `high`. Returns empty bounds if the number
/// itself is the radius.
///
/// Throws UnknownNumber (selection.h) if `scale.by` is a numeric column that the particles lack.
/// Throws SourceError with the key "radius_by" for another missing column, for a number that is not
/// known and for a radius outside ranges::length.
NumberBounds apply(const RadiusScale& scale, Particles& particles);

}  // namespace parray::input
