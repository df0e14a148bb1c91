#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// Words, lists and numbers in text. Nothing depends on the locale.
namespace parray::base {

/// Returns `text` without spaces and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// Returns at most `length` characters of `line` from `start` (0: the first) on, without spaces and
/// tabs at their ends. Empty if `line` is shorter.
inline std::string_view field_at(std::string_view line, std::size_t start, std::size_t length) {
  return line.size() <= start ? std::string_view() : trimmed(line.substr(start, length));
}

/// Returns `text` with ASCII letters in lower case.
std::string lower_case(std::string_view text);
std::vector<std::string> lower_case(const std::vector<std::string_view>& texts);

/// Replaces `fields` by the words of `line`, which spaces and tabs separate. They refer to `line`.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& fields);

/// Returns the words of `line`, which one or more of the characters `separators` separate. They
/// refer to `line`.
std::vector<std::string_view> words_of(std::string_view line, std::string_view separators = " \t");

/// Returns the parts of `text` between separators: one more than there are separators, empty ones
/// included. They refer to `text`.
std::vector<std::string_view> split_at(char separator, std::string_view text);

/// Returns the words with `between` between them. `words` are strings or views of strings.
std::string joined(const auto& words, std::string_view between) {
  std::string text;
  bool first = true;
  for (const auto& word : words) {
    if (!first) text += between;
    text += word;
    first = false;
  }
  return text;
}

/// Parses all of `text` as a number, with the rules of std::from_chars: no blanks and no leading
/// '+'; "inf" and "nan" are floats. Returns nothing for other texts and for numbers that the type
/// cannot hold. `format`: the base of a whole number, or the std::chars_format of a float.
template <typename Number, typename... Format>
std::optional<Number> parsed(std::string_view text, Format... format) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number, format...);
  return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

/// Returns parsed(text) if it is a number from `least` to `most`; otherwise nothing, also for NaN.
template <typename Number>
std::optional<Number> parsed_between(std::string_view text, Number least, Number most) {
  const std::optional<Number> number = parsed<Number>(text);
  return number && *number >= least && *number <= most ? number : std::nullopt;
}

/// Returns the index of the first of `words` that equals `word`; nothing if none does.
std::optional<std::size_t> place_in(const auto& words, std::string_view word) {
  const auto found = std::find(std::begin(words), std::end(words), word);
  if (found == std::end(words)) return std::nullopt;
  return static_cast<std::size_t>(found - std::begin(words));
}

/// Returns all of `text` as a finite number, also with a leading '+'; nothing for other texts.
std::optional<double> number_in(std::string_view text);

/// Returns number_in(text), or NaN if that returns nothing.
double number_or_nan(std::string_view text);

/// Returns all of `text` as a whole number from 0 to 2^64 - 1, written in digits alone; nothing for
/// other texts.
inline std::optional<std::uint64_t> natural_in(std::string_view text) {
  return parsed<std::uint64_t>(text);
}

inline bool is_number(std::string_view text) { return number_in(text).has_value(); }
inline bool is_natural(std::string_view text) { return natural_in(text).has_value(); }

}  // namespace parray::base
