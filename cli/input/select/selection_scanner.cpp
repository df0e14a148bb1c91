#include "cli/input/select/selection_scanner.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::string_view blank_characters = " \t\n\r";
constexpr std::string_view digit_characters = "0123456789";
/// Characters that end a name without quotes.
constexpr std::string_view name_ends = " \t\n\r(),\"&|<>=!";

bool is_among(char c, std::string_view characters) {
  return characters.find(c) != std::string_view::npos;
}
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// Returns whether a name is a word that ends a list of names.
bool joins_conditions(std::string_view name) {
  constexpr std::array<std::string_view, 3> joints{"and", "or", "not"};
  return std::ranges::find(joints, lower_case(name)) != joints.end();
}

}  // namespace

std::size_t SelectionScanner::next() {
  at_ = std::min(text_.find_first_not_of(blank_characters, at_), text_.size());
  return at_;
}

std::size_t SelectionScanner::column() { return column_of(next()); }

bool SelectionScanner::next_is(std::string_view sign) {
  return text_.substr(next()).starts_with(sign);
}

bool SelectionScanner::next_is_digit() { return !at_end() && is_among(here(), "0123456789."); }

bool SelectionScanner::next_is_letter() { return !at_end() && is_letter(here()); }

bool SelectionScanner::take_sign(std::string_view sign) {
  if (!next_is(sign)) return false;
  at_ += sign.size();
  return true;
}

bool SelectionScanner::take_word(std::string_view known) {
  const std::size_t start = next();
  if (next_is_letter() && word() == known) return true;
  at_ = start;
  return false;
}

void SelectionScanner::expect_word(std::string_view known, std::string_view form) {
  if (take_word(known)) return;
  fail(next(), "'" + std::string(known) + "' is missing: write " + std::string(form));
}

std::string SelectionScanner::word() {
  const std::size_t start = next();
  while (is_letter(here()) || (at_ < text_.size() && is_among(here(), "0123456789."))) ++at_;
  if (here() == '[') {
    const std::size_t close = text_.find_first_not_of(digit_characters, at_ + 1);
    if (close != std::string_view::npos && text_[close] == ']') at_ = close + 1;
  }
  return lower_case(text_.substr(start, at_ - start));
}

double SelectionScanner::number() {
  const std::size_t start = next();
  double value = 0;
  const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
  if (error != std::errc() || !std::isfinite(value)) {
    fail(start, "'" + shown(start) + "' is not a finite number: write a number");
  }
  at_ = static_cast<std::size_t>(end - text_.data());
  return value;
}

std::string SelectionScanner::quoted() {
  const std::size_t start = next();
  const std::size_t end = text_.find('"', start + 1);
  if (end == std::string_view::npos) fail(start, "the quote is not closed: add '\"'");
  at_ = end + 1;
  return std::string(text_.substr(start + 1, end - start - 1));
}

std::optional<std::string> SelectionScanner::name() {
  while (take_sign(",")) continue;
  if (next_is("\"")) return quoted();
  const std::size_t start = next();
  const std::string_view name = text_.substr(start, end_of_name(start) - start);
  if (name.empty() || joins_conditions(name)) return {};
  at_ = start + name.size();
  return std::string(name);
}

std::size_t SelectionScanner::end_of_name(std::size_t at) const {
  return std::min(text_.find_first_of(name_ends, at), text_.size());
}

std::string SelectionScanner::shown(std::size_t at) const {
  constexpr std::size_t longest = 20;
  return printable(text_.substr(at, std::max<std::size_t>(end_of_name(at) - at, 1)), longest);
}

std::size_t SelectionScanner::column_of(std::size_t at) const {
  if (at < known_at_) known_at_ = known_characters_ = 0;
  const auto begins_character = [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  };
  const std::string_view more = text_.substr(known_at_, at - known_at_);
  known_characters_ += static_cast<std::size_t>(std::ranges::count_if(more, begins_character));
  known_at_ = at;
  return known_characters_ + 1;
}

void SelectionScanner::fail(std::size_t at, const std::string& problem) const {
  fail_at_column(column_of(at), problem);
}

void SelectionScanner::fail_at_column(std::size_t column, const std::string& problem) {
  throw InputError("character " + std::to_string(column) + ": " + problem);
}

}  // namespace parray::input
