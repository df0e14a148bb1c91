#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// `text` made fit for a one-line message on a terminal.
///
/// Control characters, invisible characters that reorder a line and bytes that are not UTF-8
/// become escapes (\x1b, \u202e), so that a file's contents cannot drive the reader's terminal.
/// A text whose escaped form is longer than `max_bytes` is cut at a whole character and ends in
/// "...".
std::string printable(std::string_view text, std::size_t max_bytes = 60);

/// The shortest decimal text that reads back as `value`: "0.1", "1e+30", "-3".
std::string number_text(double value);

}  // namespace parray::base
