#include "cli/input/particles/particle_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::vector<std::string> lower_case(const std::vector<std::string_view>& texts) {
  std::vector<std::string> lower(texts.size());
  std::ranges::transform(texts, lower.begin(),
                         [](std::string_view text) { return lower_case(text); });
  return lower;
}

void split_at_blanks(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  const char* at = line.data();
  const char* const end = at + line.size();
  for (;;) {
    at = std::find_if_not(at, end, is_blank);
    if (at == end) return;
    const char* const start = at;
    at = std::find_if(at, end, is_blank);
    fields.emplace_back(start, static_cast<std::size_t>(at - start));
  }
}

std::optional<double> number_in(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  if (plus) text.remove_prefix(1);
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return {};
  return value;
}

double number_or_nan(std::string_view text) {
  return number_in(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::optional<std::uint64_t> natural_in(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return {};
  return value;
}

double number_field(std::string_view text, std::string_view what, const FilePlace& place) {
  const std::optional<double> value = number_in(text);
  if (!value) {
    place.fail(std::string(what) + " '" + printable(text) +
               "' is not a finite number: write it as 0.5 or 1e3");
  }
  return *value;
}

std::uint64_t count_field(std::string_view text, const FilePlace& place) {
  const std::optional<std::uint64_t> count = natural_in(text);
  if (!count) {
    place.fail("'" + printable(text) + "' is not a number of particles: write a whole number");
  }
  if (*count > limits::max_spheres) {
    place.fail(std::to_string(*count) + " particles are too many: use at most " +
               std::to_string(limits::max_spheres));
  }
  return *count;
}

}  // namespace parray::input
