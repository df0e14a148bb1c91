#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/rooms.h"

namespace parray::adaptive {
struct ErrorFigures;
}
namespace parray::farm {
struct JobStatus;
}

/// Numbers, errors and tables as text for people.
namespace parray::output {

/// Does the same as std::snprintf, and returns at most 63 characters.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  return length < 0 ? std::string() : std::string(text.data());
}

/// Returns a number with three significant digits and an SI prefix before `unit`: "3.14 M
/// samples/s". Below 1: two decimals and no prefix. Returns "? samples/s" for negative and not
/// finite numbers.
std::string with_unit(double value, std::string_view unit);

/// Returns a time in seconds as "0.25 s", "12 s", "3 min 20 s", "2 h 05 min" or "3 d 4 h". Returns
/// "?" for negative and not finite numbers.
std::string duration_text(double length);

/// Returns the local time of seconds since 1970: "2026-11-22 16:05:09".
std::string moment_text(double since_1970);

/// Returns a size as "512 bytes", "23.4 KiB" or "1.20 GiB".
std::string bytes_text(std::uint64_t bytes);

/// Returns a mean number, such as of samples per pixel, with three digits or as a whole number:
/// "6.52", "1316".
std::string mean_text(double mean);

/// Returns a number with at most six significant digits: "11111.1", "0.18", "1e+15".
std::string number_cell(double value);

/// Returns a count with its noun: "1 sample", "16 samples".
std::string counted(std::uint64_t count, std::string_view noun);

/// Formats rows below a header. Spaces align the columns; the last cell of a line is not padded.
/// Every row has as many cells as the header. Ends with a newline.
std::string table_text(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows);

/// Returns "name   value" lines with aligned values. Ends with a newline.
std::string list_text(const std::vector<std::pair<std::string, std::string>>& pairs);

/// Returns RMSE and its confidence interval with three digits: "0.0094 (0.0092 to 0.0096)". Returns
/// "" if they are unknown.
std::string figures_text(const ErrorFigures& error);

/// Returns the error in a report: "error 0.0094 (0.0092 to 0.0096)", or "error not known". For a
/// denoised picture, the error before denoising follows.
std::string error_text(const nlohmann::json& report);

/// Returns the error of a job and its target: "error 0.021 of 0.01", where 0.021 is the upper end
/// of the RMSE's confidence interval. For a target half-width: "half-width 0.1 of 0.05", where 0.1
/// is the 99th percentile of the pixels' half-widths. Returns "" without a target, and while the
/// error is unknown.
std::string target_text(const JobStatus& job);

}  // namespace parray::output
