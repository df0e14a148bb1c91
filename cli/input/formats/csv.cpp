#include <algorithm>
#include <array>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Returns the first lines that are neither blank nor comments (#).
Fields rows_of(const FileStart& start, std::size_t most) {
  Fields rows;
  for (const std::string_view line : start.lines()) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    rows.push_back(line);
    if (rows.size() == most) break;
  }
  return rows;
}

Confidence looks_like_csv(const FileStart& start) {
  const Fields rows = rows_of(start, 2);
  if (rows.empty()) return Confidence::none;
  constexpr std::string_view separators = " \t,;\"";
  const std::string header = lower_case(rows[0]);
  const Fields names = words_of(header, separators);
  const auto has_name = [&](std::string_view name) { return std::ranges::count(names, name) > 0; };
  if (has_name("x") && has_name("y") && has_name("z")) return Confidence::likely;
  if (rows.size() < 2 || names.size() < 3) return Confidence::none;
  const Fields fields = words_of(rows[1], separators);  // a table whose columns have other names
  const auto numbers = std::ranges::count_if(fields, is_number);
  return fields.size() == names.size() && numbers >= 3 ? Confidence::possible : Confidence::none;
}

using AxisNames = std::array<std::string, 3>;

constexpr std::array<std::string_view, 3> axis_letters{"x", "y", "z"};
constexpr std::array<std::string_view, 3> axis_numbers{"0", "1", "2"};
constexpr std::array<std::string_view, 13> words_for_positions{
    "pos",        "position", "positions", "point",    "points",   "coord",      "coords",
    "coordinate", "center",   "centre",    "centroid", "location", "coordinates"};

std::string without_unit(std::string name) {
  for (const std::string_view brackets : {"[]", "()"}) {
    const std::size_t open = name.rfind(brackets[0]);
    if (open == std::string::npos || open == 0 || !name.ends_with(brackets[1])) continue;
    name.resize(open);
  }
  return std::string(trimmed(name));
}

/// Keeps only letters and digits: "Points:0" and "points_0" become equal.
std::string bare(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) letters += c;
  }
  return letters;
}

/// Returns the known sets of names for three axes, by preference.
std::vector<AxisNames> ways_to_write_axes() {
  std::vector<AxisNames> ways;
  const auto add = [&ways](const auto& name_of) {
    ways.push_back({name_of(std::size_t{0}), name_of(std::size_t{1}), name_of(std::size_t{2})});
  };
  for (const std::string_view word : words_for_positions) {
    const std::string text(word);
    add([&](std::size_t i) { return text + std::string(axis_letters.at(i)); });
    add([&](std::size_t i) { return text + std::string(axis_numbers.at(i)); });
    add([&](std::size_t i) { return std::string(axis_letters.at(i)) + text; });
  }
  return ways;
}

bool has(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

/// Returns the column names in the form that layout_of() knows: lower case, without a unit in
/// brackets at the end ("x [nm]", "vx (m/s)"). Renames position columns to x, y and z. Programs
/// call them pos_x, PositionX, x_coord, Points:0 (ParaView), Position.X (OVITO) and so on. If a
/// column is called x, y or z, it is the position.
std::vector<std::string> csv_names(const std::vector<std::string_view>& header) {
  std::vector<std::string> names = lower_case(header);
  for (std::string& name : names) name = without_unit(name);
  const auto is_there = [&names](std::string_view axis) { return has(names, axis); };
  if (std::ranges::any_of(axis_letters, is_there)) return names;
  std::vector<std::string> bare_names;
  std::ranges::transform(names, std::back_inserter(bare_names), bare);
  for (const AxisNames& way : ways_to_write_axes()) {
    if (!std::ranges::all_of(way, [&](const auto& name) { return has(bare_names, name); })) {
      continue;
    }
    for (std::size_t i = 0; i < way.size(); ++i) {
      const auto found = std::ranges::find(bare_names, way.at(i)) - bare_names.begin();
      names[static_cast<std::size_t>(found)] = axis_letters.at(i);
    }
    break;
  }
  return names;
}

constexpr char blank_separator = ' ';
constexpr char quote_mark = '"';

/// Splits lines at a separator. Removes quotes and blanks around fields. Fields are valid until the
/// next line.
class Splitter {
 public:
  explicit Splitter(char separator) : separator_(separator) {}

  void split(std::string_view line, const FilePlace& place, Fields& fields) {
    fields.clear();
    if (line.find(quote_mark) != std::string_view::npos) {
      split_quoted(line, place, fields);
    } else if (separator_ == blank_separator) {
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

  /// Unquotes into text_. The size of text_ stays constant for each line, because fields point into
  /// it.
  void split_quoted(std::string_view line, const FilePlace& place, Fields& fields) {
    text_.assign(line.size(), '\0');
    std::size_t filled = 0;
    std::string_view rest = separator_ == blank_separator ? trimmed(line) : line;
    for (;;) {
      skip(rest, " ");  // not tabs, because tabs may separate empty fields
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
      separator_ == blank_separator ? skip(rest, " \t") : rest.remove_prefix(1);
    }
  }

  static void skip(std::string_view& text, std::string_view characters) {
    text.remove_prefix(std::min(text.find_first_not_of(characters), text.size()));
  }

  std::size_t end_of_field(std::string_view rest) const {
    return separator_ == blank_separator ? rest.find_first_of(" \t") : rest.find(separator_);
  }

  void take_quoted(std::string_view& rest, std::size_t& filled, const FilePlace& place) {
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

  char separator_;
  std::string text_;
};

/// Returns the first comma, semicolon or tab outside quotes. Returns a blank if there is none.
char separator_of(std::string_view header) {
  bool quoted = false;
  for (const char c : header) {
    if (c == quote_mark) quoted = !quoted;
    if (!quoted && (c == ',' || c == ';' || c == '\t')) return c;
  }
  return blank_separator;
}

bool next_row(ParticleInput& input) {
  while (input.next_filled_line()) {
    if (!trimmed(input.line()).starts_with('#')) return true;
  }
  return false;
}

/// Reads a table with one header line. layout_of() interprets the names of the columns, in any
/// letter case. The first comma, semicolon or tab of the header is the separator; without one,
/// blanks separate fields. Fields may be in double quotes ("" is a quote). Ignores blank lines and
/// comments, which start with #. If any colour component is above 1, all colours are whole numbers
/// 0 to 255 (8-bit sRGB); otherwise they are linear.
Particles read_csv(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  if (!next_row(input)) {
    input.fail("the file has no header line: add one that names the columns x, y and z");
  }
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
      input.fail(std::to_string(row.size()) + " fields, but the header has " +
                 std::to_string(names.size()) + ": use the same number");
    }
    add_row(row, layout, input.place(), columns);
  }
  return columns.finish();
}

}  // namespace

constinit const ParticleFormat csv_format{
    .name = "CSV", .extensions = {".csv"}, .confidence = looks_like_csv, .read = read_csv};

}  // namespace parray::input
