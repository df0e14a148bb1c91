#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

/// Letters of 5 x 7 dots, for legends inside pictures: digits, ". - + %" and some small letters.
namespace parray {

inline constexpr std::size_t glyph_height = 7;
/// From one letter to the next: five dots and a gap.
inline constexpr std::size_t glyph_advance = 6;

/// Dots from the first letter to the last.
constexpr std::size_t text_width(std::string_view text) {
  return text.empty() ? 0 : text.size() * glyph_advance - 1;
}

/// Calls `dot(x, y)` for every dot of `text`, from (0, 0) rightwards and downwards. Throws
/// std::logic_error for a character that the font lacks.
void each_dot(std::string_view text, const std::function<void(std::size_t, std::size_t)>& dot);

}  // namespace parray
