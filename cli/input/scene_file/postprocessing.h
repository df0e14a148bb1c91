#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "cli/input/color/number_bounds.h"
#include "common/scene/limits.h"

/// Postprocessing of a picture. EXR files stay as traced.
namespace parray::input {

/// The width of drawn lines.
struct LineWidth {
  enum class Unit : std::uint8_t {
    none,       ///< no lines
    automatic,  ///< 1/450 of the picture's height, at least one pixel
    pixels,
    points  ///< 72 points are an inch of print
  };
  Unit unit = Unit::none;
  double value = 0;  ///< number of pixels or points; in drawing_ranges::line_width

  friend bool operator==(const LineWidth&, const LineWidth&) = default;
};

struct Postprocessing {
  LineWidth outline{};  ///< width of lines around shapes in front of something farther away
  /// Share of the background, 0 to 1, in the colour of the farthest surface. The share is 0 at the
  /// nearest surface and grows linearly with depth. 0: no depth cue.
  double depth_cue = 0;
  /// Depths of the nearest and the farthest surface of all frames of a film: distances from the
  /// camera along its direction of view, in the scene's unit. Empty: those of the picture. Scene
  /// files do not contain them.
  NumberBounds depths{};

  friend bool operator==(const Postprocessing&, const Postprocessing&) = default;
};

/// The depth cue for the word "on".
inline constexpr double usual_depth_cue = 0.6;

namespace drawing_ranges {
inline constexpr NumberRange line_width{0.1, 100};  ///< pixels or points
inline constexpr NumberRange depth_cue{0, 1};
}  // namespace drawing_ranges

/// Parses "on", "off", a number of pixels, or a number of points such as "0.5pt". Throws InputError
/// for other texts.
LineWidth line_width_from(std::string_view text);
/// Parses "on", "off" or a number. Throws InputError for other texts.
double depth_cue_from(std::string_view text);

/// The section `finishing` of a scene file. Members that the file does not name are not set.
struct PostprocessingSection {
  std::optional<LineWidth> outline{};
  std::optional<double> depth_cue{};

  /// Returns `other`, in which the members that are set here replace those of `other`.
  [[nodiscard]] Postprocessing over(const Postprocessing& other) const;
};

}  // namespace parray::input
