#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Returns `text` in a form for a one-line message on a terminal.
///
/// Control characters, common invisible characters (U+AD, U+061C, U+180E, U+200B to U+200F, U+2028
/// to U+202E, U+2060 to U+206F, U+FEFF, U+E0000 to U+E007F; some reorder a line), and bytes that
/// are not UTF-8 become escapes (\x1b, \u202e, \U000e0041). So the contents of a file cannot
/// control the reader's terminal. If the escaped form is longer than `max_bytes`, it is cut after a
/// whole character and ends in "...", which counts towards `max_bytes`.
std::string printable(std::string_view text, std::size_t max_bytes = 60);

struct CodePoint {
  std::size_t length = 0;  ///< bytes; 0: not UTF-8 (RFC 3629)
  char32_t value = 0;
};
/// Decodes the first character of `text`, which must not be empty. Rejects overlong forms and
/// surrogates.
CodePoint first_code_point(std::string_view text);

/// Returns the shortest decimal text that reads back as `value`: "0.1", "1e+30", "-3".
std::string number_text(double value);

}  // namespace parray::base
