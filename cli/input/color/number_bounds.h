#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/math/vec.h"

namespace parray::input {

/// The least and the largest of the numbers that were added. Empty before the first one.
struct NumberBounds {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(const NumberBounds& more) {
    low = std::min(low, more.low);
    high = std::max(high, more.high);
  }
  [[nodiscard]] bool empty() const { return low > high; }
  friend bool operator==(const NumberBounds&, const NumberBounds&) = default;
};

/// The bounds of positions along the axes.
struct PositionBounds {
  Vec3d low;
  Vec3d high = low;

  void add(const Vec3d& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};
/// `positions`: not empty.
inline PositionBounds bounds_of(std::span<const Vec3d> positions) {
  PositionBounds bounds{positions.front()};
  for (const Vec3d& p : positions) bounds.add(p);
  return bounds;
}

/// One end of a range.
struct RangeEnd {
  double value = 0;  ///< finite; 40 for "40%"
  bool percent = false;

  friend bool operator==(const RangeEnd&, const RangeEnd&) = default;
};

/// A range such as "10:20", "40%:60%" or ":5". A missing end is open.
struct TextRange {
  std::optional<RangeEnd> low{};
  std::optional<RangeEnd> high{};

  [[nodiscard]] bool open() const { return !low && !high; }
  friend bool operator==(const TextRange&, const TextRange&) = default;
};

/// Parses a range. Returns nothing for other texts and for a range without ends. Does not compare
/// the ends.
std::optional<TextRange> text_range(std::string_view text);

/// Returns the text that text_range() parses to `range`. Returns "" for an open range.
std::string text_of(const TextRange& range);

}  // namespace parray::input
