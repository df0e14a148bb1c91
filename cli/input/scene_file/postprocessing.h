#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/scene/number_range.h"

/// What is done to a picture of a scene before it is looked at. EXR files keep what was traced.
namespace parray::input {

/// Of lines that are drawn.
struct LineWidth {
  enum class Unit : std::uint8_t {
    none,       ///< no lines
    automatic,  ///< a 450th of the picture's height, and at least a pixel
    pixels,
    points  ///< 72 of them are an inch of print
  };
  Unit unit = Unit::none;
  double value = 0;  ///< of pixels and points; in drawing_ranges::line_width

  friend bool operator==(const LineWidth&, const LineWidth&) = default;
};

struct Postprocessing {
  LineWidth outline{};   ///< around spheres, where something is farther away
  double depth_cue = 0;  ///< share of the background that the farthest surface fades to; 0: none

  friend bool operator==(const Postprocessing&, const Postprocessing&) = default;
};

inline constexpr double usual_depth_cue = 0.6;

namespace drawing_ranges {
inline constexpr NumberRange line_width{0.1, 100};
inline constexpr NumberRange depth_cue{0, 1};
}  // namespace drawing_ranges

/// "on", "off", a number of pixels or, as "0.5pt", of points. Throws InputError.
LineWidth line_width_from(std::string_view text);
/// "on", "off" or a number. Throws InputError.
double depth_cue_from(std::string_view text);

/// A scene's section `finishing`; what it does not name is not set.
struct PostprocessingSection {
  std::optional<LineWidth> outline{};
  std::optional<double> depth_cue{};

  /// Laid over what a style has.
  [[nodiscard]] Postprocessing over(const Postprocessing& other) const;
};

}  // namespace parray::input
