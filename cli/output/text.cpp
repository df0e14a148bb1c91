#include "cli/output/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

namespace parray::output {
namespace {

/// Returns three significant digits without an exponent, for 0 <= value < 1000.
std::string three_digits(double value) {
  const int decimals = value < 9.995 ? 2 : (value < 99.95 ? 1 : 0);
  return formatted("%.*f", decimals, value);
}

/// Returns the number of columns on a terminal: characters of UTF-8, not bytes.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::string with_unit(double value, std::string_view unit) {
  constexpr std::array<const char*, 7> prefixes = {"", "k ", "M ", "G ", "T ", "P ", "E "};
  const std::string tail(unit);
  if (!std::isfinite(value) || value < 0) return "? " + tail;
  std::size_t prefix = 0;
  while (value >= 999.5 && prefix + 1 < prefixes.size()) {
    value /= 1000;
    ++prefix;
  }
  return three_digits(value) + " " + prefixes[prefix] + tail;
}

std::string moment_text(double since_1970) {
  constexpr double longest = 1e11;  // about 3000 years; a limit that is safe to convert
  const auto whole = static_cast<std::time_t>(std::clamp(since_1970, 0.0, longest));
  std::tm local{};
  localtime_r(&whole, &local);
  std::array<char, 32> text{};
  static_cast<void>(std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &local));
  return text.data();
}

std::string duration_text(double length) {
  if (!std::isfinite(length) || length < 0) return "?";
  constexpr double longest = 1e9;  // about 30 years; a limit that is safe to convert
  length = std::min(length, longest);
  if (length < 9.95) return formatted("%.2g s", length);
  const auto whole = static_cast<long>(std::lround(length));
  constexpr long minute = 60;
  constexpr long hour = 60 * minute;
  constexpr long day = 24 * hour;
  if (whole < minute) return formatted("%ld s", whole);
  if (whole < hour) return formatted("%ld min %02ld s", whole / minute, whole % minute);
  if (whole < day) return formatted("%ld h %02ld min", whole / hour, whole % hour / minute);
  return formatted("%ld d %ld h", whole / day, whole % day / hour);
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::array<const char*, 4> units = {"KiB", "MiB", "GiB", "TiB"};
  if (bytes < 1024) return counted(bytes, "byte");
  double value = static_cast<double>(bytes) / 1024;
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < units.size()) {
    value /= 1024;
    ++unit;
  }
  return three_digits(value) + " " + units[unit];
}

std::string number_cell(double value) { return formatted("%.6g", value); }

std::string mean_text(double mean) { return formatted(mean < 999.5 ? "%.3g" : "%.0f", mean); }

std::string counted(std::uint64_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

std::string table_text(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < header.size(); ++c) {
    std::size_t width = columns_of(header[c]);
    for (const auto& row : rows) width = std::max(width, columns_of(row[c]));
    widths.push_back(width);
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      text += row[c];
      if (c + 1 < row.size()) text += std::string(widths[c] - columns_of(row[c]) + 2, ' ');
    }
    text += '\n';
  };
  add(header);
  for (const auto& row : rows) add(row);
  return text;
}

std::string list_text(const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::size_t width = 0;
  for (const auto& [name, value] : pairs) width = std::max(width, columns_of(name));
  std::string text;
  for (const auto& [name, value] : pairs) {
    text += name;
    text.append(width - columns_of(name) + 2, ' ');
    text += value;
    text += '\n';
  }
  return text;
}

}  // namespace parray::output
