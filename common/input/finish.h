#pragma once

#include <cstdint>

#include "common/scene/number_range.h"

/// What is done to a picture of a scene before it is looked at. EXR files keep what was traced.
namespace parray {

/// Of lines that are drawn.
struct LineWidth {
  enum class Unit : std::uint8_t {
    none,       ///< no lines
    automatic,  ///< one 450th of the picture's height, and at least a pixel
    pixels,
    points  ///< 72 of them are an inch of print
  };
  Unit unit = Unit::none;
  double value = 0;  ///< of pixels and points; in ranges::line_width

  friend bool operator==(const LineWidth&, const LineWidth&) = default;
};

struct Finish {
  LineWidth outline{};
  double depth_cue = 0;  ///< share of the background that the farthest surface fades to; 0: none

  friend bool operator==(const Finish&, const Finish&) = default;
};

inline constexpr double usual_depth_cue = 0.6;

namespace ranges {
inline constexpr NumberRange line_width{0.1, 100};
inline constexpr NumberRange depth_cue{0, 1};
}  // namespace ranges

}  // namespace parray
