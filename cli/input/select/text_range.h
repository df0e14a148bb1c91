#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// One end of a range as somebody wrote it.
struct RangeEnd {
  double value = 0;  ///< finite
  bool percent = false;

  friend bool operator==(const RangeEnd&, const RangeEnd&) = default;
};

/// "10:20", "40%:60%", ":5"; what is not given is left open.
struct TextRange {
  std::optional<RangeEnd> low{};
  std::optional<RangeEnd> high{};

  [[nodiscard]] bool open() const { return !low && !high; }
  friend bool operator==(const TextRange&, const TextRange&) = default;
};

/// Nothing when `text` is no range, or names neither end.
std::optional<TextRange> text_range(std::string_view text);

/// The text that is read as this.
std::string text_of(const TextRange& range);

}  // namespace parray::input
