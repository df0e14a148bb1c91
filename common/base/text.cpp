#include "common/base/text.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/ascii.h"

namespace parray::base {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && ascii::is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && ascii::is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), ascii::lower);
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
    at = std::find_if_not(at, end, ascii::is_blank);
    if (at == end) return;
    const char* const start = at;
    at = std::find_if(at, end, ascii::is_blank);
    fields.emplace_back(start, static_cast<std::size_t>(at - start));
  }
}

std::vector<std::string_view> words_of(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> words;
  for (;;) {
    line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(separators)));
    line.remove_prefix(words.back().size());
  }
}

std::vector<std::string_view> split_at(char separator, std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::optional<double> number_in(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  if (plus) text.remove_prefix(1);
  const std::optional<double> value = parsed<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

double number_or_nan(std::string_view text) {
  return number_in(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace parray::base
