#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/rooms.h"

/// Numbers and tables as text for people.
namespace parray::output {

/// std::snprintf as a function: at most 63 characters.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  return length < 0 ? std::string() : std::string(text.data());
}

/// A number with three significant digits and an SI prefix before `unit`: "3.14 M samples/s".
/// Below 1: no prefix. Not finite or negative: "? samples/s".
std::string with_unit(double value, std::string_view unit);

/// "0.25 s", "12 s", "3 min 20 s", "2 h 05 min", "3 d 4 h". Negative or not finite: "?".
std::string duration_text(double length);

/// "2026-11-22 16:05:09", local time, of seconds since 1970.
std::string moment_text(double since_1970);

/// "512 bytes", "23.4 KiB", "1.2 GiB".
std::string bytes_text(std::uint64_t bytes);

/// Six significant digits at most: "11111.1", "0.18", "1e+15".
std::string number_cell(double value);

/// "1 sample", "16 samples".
std::string counted(std::uint64_t count, std::string_view noun);

/// Formats rows below a header. Spaces align the columns; the last cell of a line is not padded.
/// Every row has as many cells as the header. Ends with a newline.
std::string table_text(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows);

/// "name   value" lines, the values aligned. Ends in a newline.
std::string list_text(const std::vector<std::pair<std::string, std::string>>& pairs);

}  // namespace parray::output
