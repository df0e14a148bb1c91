#include "cli/output/text.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <span>

#include "cli/farm/client.h"
#include "common/adaptive/error_estimate.h"
#include "coordinator/jobs/report.h"

namespace parray::output {
namespace {

/// Returns three significant digits without an exponent, for 0 <= value < 1000.
std::string three_digits(double value) {
  const int decimals = value < 9.995 ? 2 : (value < 99.95 ? 1 : 0);
  return formatted("%.*f", decimals, value);
}

/// Returns three digits of `value` in the first of `units` for which they suffice. Each unit is
/// `step` times the one before.
std::string in_units(double value, double step, std::span<const char* const> units) {
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < units.size()) {
    value /= step;
    ++unit;
  }
  return three_digits(value) + " " + units[unit];
}

/// Returns the number of columns on a terminal: characters of UTF-8, not bytes.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Pads all cells but the last of each line to the width of their column.
std::string aligned(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths(lines.empty() ? 0 : lines.front().size());
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      widths[c] = std::max(widths[c], columns_of(line[c]));
    }
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t c = 0; c + 1 < widths.size(); ++c) {
      text += line[c] + std::string(widths[c] - columns_of(line[c]) + 2, ' ');
    }
    text += line.back() + '\n';
  }
  return text;
}

std::string figure(double value) { return formatted("%.3g", value); }

}  // namespace

std::string with_unit(double value, std::string_view unit) {
  constexpr std::array<const char*, 7> prefixes = {"", "k ", "M ", "G ", "T ", "P ", "E "};
  const std::string tail(unit);
  if (!std::isfinite(value) || value < 0) return "? " + tail;
  return in_units(value, 1000, prefixes) + tail;
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
  return in_units(static_cast<double>(bytes) / 1024, 1024, units);
}

std::string number_cell(double value) { return formatted("%.6g", value); }

std::string mean_text(double mean) { return formatted(mean < 999.5 ? "%.3g" : "%.0f", mean); }

std::string counted(std::uint64_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

std::string table_text(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::vector<std::string>> lines = {header};
  lines.insert(lines.end(), rows.begin(), rows.end());
  return aligned(lines);
}

std::string list_text(const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::vector<std::vector<std::string>> lines;
  lines.reserve(pairs.size());
  for (const auto& [name, value] : pairs) lines.push_back({name, value});
  return aligned(lines);
}

std::string figures_text(const ErrorFigures& error) {
  if (!error.known()) return "";
  return figure(error.rmse) + " (" + figure(error.low) + " to " + figure(error.high) + ")";
}

std::string error_text(const nlohmann::json& report) {
  const ErrorFigures error = error_from_json(report.value("error", nlohmann::json()));
  const std::string raw = error.known() ? figures_text(error) : "not known";
  const auto denoised = report.find("denoised");
  if (denoised == report.end()) return "error " + raw;
  return "error " + figures_text(error_from_json(*denoised)) + ", " + raw + " before denoising";
}

std::string target_text(const JobStatus& job) {
  std::string text;
  const auto add = [&text](const char* what, double value, double target) {
    if (target <= 0 || value < 0) return;
    text +=
        (text.empty() ? "" : ", ") + std::string(what) + figure(value) + " of " + figure(target);
  };
  add("error ", job.error.high, job.target_error);
  add("half-width ", job.error.half_width_p99, job.target_half_width);
  return text;
}

}  // namespace parray::output
