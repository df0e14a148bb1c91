#include "cli/input/formats/table_rows.h"

#include <algorithm>

#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr char quote_mark = '"';

void skip_any(std::string_view& text, std::string_view characters) {
  text.remove_prefix(std::min(text.find_first_not_of(characters), text.size()));
}

}  // namespace

bool is_table_comment(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.starts_with('#') || text.starts_with("//") || text.starts_with('%');
}

void FieldSplitter::split(std::string_view line, const FilePlace& place,
                          std::vector<std::string_view>& fields) {
  fields.clear();
  if (line.find(quote_mark) != std::string_view::npos) {
    split_quoted(line, place, fields);
  } else if (separator_ == blank_separator) {
    split_at_blanks(line, fields);
  } else {
    for (;;) {
      const std::size_t end = line.find(separator_);
      fields.push_back(trimmed(line.substr(0, end)));
      if (end == std::string_view::npos) return;
      line.remove_prefix(end + 1);
    }
  }
}

/// Unquotes into text_. The size of text_ stays constant for each line, because fields point into
/// it.
void FieldSplitter::split_quoted(std::string_view line, const FilePlace& place,
                                 std::vector<std::string_view>& fields) {
  text_.assign(line.size(), '\0');
  std::size_t filled = 0;
  std::string_view rest = separator_ == blank_separator ? trimmed(line) : line;
  for (;;) {
    skip_any(rest, " ");  // not tabs, because tabs may separate empty fields
    const std::size_t start = filled;
    if (rest.starts_with(quote_mark)) {
      take_quoted(rest, filled, place);
    } else {
      const std::size_t end = std::min(end_of_field(rest), rest.size());
      filled += trimmed(rest.substr(0, end)).copy(text_.data() + filled, end);
      rest.remove_prefix(end);
    }
    fields.emplace_back(text_.data() + start, filled - start);
    if (rest.empty()) return;
    separator_ == blank_separator ? skip_any(rest, " \t") : rest.remove_prefix(1);
  }
}

std::size_t FieldSplitter::end_of_field(std::string_view rest) const {
  return separator_ == blank_separator ? rest.find_first_of(" \t") : rest.find(separator_);
}

void FieldSplitter::take_quoted(std::string_view& rest, std::size_t& filled,
                                const FilePlace& place) {
  rest.remove_prefix(1);
  for (;;) {
    const std::size_t end = rest.find(quote_mark);
    if (end == std::string_view::npos) place.fail("the quote is not closed: add '\"'");
    filled += rest.copy(text_.data() + filled, end);
    rest.remove_prefix(end + 1);
    if (!rest.starts_with(quote_mark)) break;
    text_[filled++] = quote_mark;
    rest.remove_prefix(1);
  }
  const std::size_t next = std::min(end_of_field(rest), rest.size());
  if (!trimmed(rest.substr(0, next)).empty()) {
    place.fail("text follows the closing quote: double each quote inside a quoted field");
  }
  rest.remove_prefix(next);
}

char separator_of(std::string_view header) {
  bool quoted = false;
  for (const char c : header) {
    if (c == quote_mark) quoted = !quoted;
    if (!quoted && (c == ',' || c == ';' || c == '\t')) return c;
  }
  return blank_separator;
}

std::string with_decimal_point(std::string_view field) {
  const std::size_t comma = field.find(',');
  if (comma == std::string_view::npos) return {};
  std::string text(field);
  text[comma] = '.';
  return is_number(text) ? text : std::string();
}

bool TableRows::next_line() {
  while (input_->next_filled_line()) {
    if (!is_table_comment(input_->line())) return true;
  }
  return false;
}

const std::vector<std::string_view>* TableRows::next() {
  if (!next_line()) return nullptr;
  splitter_.split(input_->line(), input_->place(), fields_);
  if (separator_ != ',') replace_commas();
  return &fields_;
}

void TableRows::replace_commas() {
  const auto has_point = [](std::string_view field) {
    return field.find('.') != std::string_view::npos && is_number(field);
  };
  const auto has_comma = [](std::string_view field) {
    return field.find(',') != std::string_view::npos;
  };
  const std::uint64_t line = input_->place().number;
  const bool commas = std::ranges::any_of(fields_, has_comma);
  if (point_line_ == 0 && std::ranges::any_of(fields_, has_point)) point_line_ = line;
  if (commas) {
    std::size_t size = 0;
    for (const std::string_view field : fields_) size += field.size();
    text_.clear();
    text_.reserve(size);  // fields point into it
    for (std::string_view& field : fields_) {
      const std::string number = with_decimal_point(field);
      if (number.empty()) continue;
      field = {text_.data() + text_.size(), number.size()};
      text_ += number;
      if (comma_line_ == 0) comma_line_ = line;
    }
  }
  if (comma_line_ == 0 || point_line_ == 0) return;
  input_->fail("the table mixes decimal commas (line " + std::to_string(comma_line_) +
               ") and decimal points (line " + std::to_string(point_line_) +
               "): write points in all numbers");
}

}  // namespace parray::input
