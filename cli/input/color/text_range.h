#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

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
