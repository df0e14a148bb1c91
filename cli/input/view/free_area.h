#pragma once

#include <vector>

#include "common/base/error.h"
#include "common/rooms.h"

/// The part of a picture that labels leave free for particles.
namespace parray::input {

/// Error: the labels do not suit the picture, such as one that is too small for them.
class LabelError : public InputError {
 public:
  using InputError::InputError;
};

/// A rectangle of a picture: x from -1 at the left edge to 1 at the right edge, y from -1 at the
/// lower edge to 1 at the upper edge.
struct PictureArea {
  double left, right, bottom, top;

  [[nodiscard]] double width() const { return right - left; }
  [[nodiscard]] double height() const { return top - bottom; }
  friend bool operator==(const PictureArea&, const PictureArea&) = default;
};

/// The places of the labels of a picture.
struct LabelPlaces {
  std::vector<PictureArea> boxes{};  ///< areas that particles must not meet; at most a few
  /// Least distances of particles from the left and right edges, in half widths of the picture, and
  /// from the lower and upper edges, in half heights.
  double margin_x = 0;
  double margin_y = 0;
};

/// Share of the picture's width or height that particles fill without labels.
inline constexpr double filled_share = 0.85;
/// The area that particles fill without labels.
inline constexpr PictureArea usual_area{-filled_share, filled_share, -filled_share, filled_share};

/// Returns the part of usual_area, outside of boxes and margins, in which a group of particles can
/// be largest. Of several such parts, returns the one with the largest area. `width` and `height`
/// (> 0) give the proportions of the group, in pictures' widths and heights: equal numbers mean the
/// proportions of the picture. Takes up to 4^n steps for n boxes.
///
/// Throws LabelError, with a remedy, if no part is a tenth of the picture wide and high.
PictureArea free_area(const LabelPlaces& labels, double width, double height);

/// Returns the area after scaling by `factor` around its centre.
PictureArea scaled(const PictureArea& area, double factor);

}  // namespace parray::input
