#include <algorithm>

#include "cli/input/formats/csv_header.h"
#include "cli/input/formats/readers.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

constexpr char blanks = ' ';
constexpr char quote = '"';

/// Splits lines at a separator. Fields lose their quotes and the blanks around them; they are valid
/// until the next line.
class Splitter {
 public:
  explicit Splitter(char separator) : separator_(separator) {}

  void split(std::string_view line, const FilePlace& place, Fields& fields) {
    fields.clear();
    if (line.find(quote) != std::string_view::npos) {
      split_quoted(line, place, fields);
    } else if (separator_ == blanks) {
      split_at_blanks(line, fields);
    } else {
      split_plain(line, fields);
    }
  }

 private:
  void split_plain(std::string_view line, Fields& fields) const {
    for (;;) {
      const std::size_t end = line.find(separator_);
      fields.push_back(trimmed(line.substr(0, end)));
      if (end == std::string_view::npos) return;
      line.remove_prefix(end + 1);
    }
  }

  /// Unquotes into text_, whose size never changes once it is set: the fields point into it.
  void split_quoted(std::string_view line, const FilePlace& place, Fields& fields) {
    text_.assign(line.size(), '\0');
    std::size_t filled = 0;
    std::string_view rest = separator_ == blanks ? trimmed(line) : line;
    for (;;) {
      skip(rest, " ");  // not tabs: they may separate empty fields
      const std::size_t start = filled;
      if (rest.starts_with(quote)) {
        take_quoted(rest, filled, place);
      } else {
        const std::size_t end = std::min(end_of_field(rest), rest.size());
        filled += trimmed(rest.substr(0, end)).copy(text_.data() + filled, end);
        rest.remove_prefix(end);
      }
      fields.emplace_back(text_.data() + start, filled - start);
      if (rest.empty()) return;
      separator_ == blanks ? skip(rest, " \t") : rest.remove_prefix(1);
    }
  }

  static void skip(std::string_view& text, std::string_view characters) {
    text.remove_prefix(std::min(text.find_first_not_of(characters), text.size()));
  }

  std::size_t end_of_field(std::string_view rest) const {
    return separator_ == blanks ? rest.find_first_of(" \t") : rest.find(separator_);
  }

  void take_quoted(std::string_view& rest, std::size_t& filled, const FilePlace& place) {
    rest.remove_prefix(1);
    for (;;) {
      const std::size_t end = rest.find(quote);
      if (end == std::string_view::npos) place.fail("a quote is not closed: close it");
      filled += rest.copy(text_.data() + filled, end);
      rest.remove_prefix(end + 1);
      if (!rest.starts_with(quote)) break;
      text_[filled++] = quote;
      rest.remove_prefix(1);
    }
    const std::size_t next = std::min(end_of_field(rest), rest.size());
    if (!trimmed(rest.substr(0, next)).empty()) {
      place.fail("text after a closing quote: write a quote in a quoted field twice");
    }
    rest.remove_prefix(next);
  }

  char separator_;
  std::string text_;
};

/// The first comma, semicolon or tab outside quotes; a blank when there is none.
char separator_of(std::string_view header) {
  bool quoted = false;
  for (const char c : header) {
    if (c == quote) quoted = !quoted;
    if (!quoted && (c == ',' || c == ';' || c == '\t')) return c;
  }
  return blanks;
}

bool next_row(ParticleInput& input) {
  while (input.next_filled_line()) {
    if (!trimmed(input.line()).starts_with('#')) return true;
  }
  return false;
}

}  // namespace

Particles read_csv(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  if (!next_row(input)) input.fail("no header line: name the columns x, y and z");
  Splitter splitter(separator_of(input.line()));
  Fields row;
  splitter.split(input.line(), input.place(), row);
  const std::vector<std::string> names = csv_names(row);
  RowLayout layout = layout_of(names, input.place());
  use_diameters(names, layout);
  layout.color_scale = ColorScale::either;
  layout.strict_elements = true;

  ParticleColumns columns(input.place());
  want_numbers(other_fields(names, layout), request, layout, columns);
  while (next_row(input)) {
    splitter.split(input.line(), input.place(), row);
    if (row.size() != names.size()) {
      input.fail(std::to_string(row.size()) + " fields where the header has " +
                 std::to_string(names.size()) + ": write as many");
    }
    add_row(row, layout, input.place(), columns);
  }
  return columns.finish();
}

}  // namespace parray::input
