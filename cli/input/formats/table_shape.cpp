#include "cli/input/formats/table_shape.h"

#include <algorithm>
#include <optional>

#include "cli/input/formats/table_rows.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t least_numbers = 3;

/// A line that is neither blank nor a comment, or a comment.
struct Line {
  std::string_view text;
  std::size_t place = 0;  ///< line of the file, from 0
};

struct Lines {
  std::vector<Line> comments;  ///< before the first row
  std::vector<Line> rows;
};

Lines lines_of(const FileStart& start) {
  Lines lines;
  for (std::size_t i = 0; i < start.lines().size(); ++i) {
    const std::string_view text = trimmed(start.line(i));
    if (text.empty()) continue;
    if (!is_table_comment(text)) {
      lines.rows.push_back({text, i});
    } else if (lines.rows.empty()) {
      lines.comments.push_back({text, i});
    }
  }
  return lines;
}

/// Returns whether a field may stand for a number: a number, also with a decimal comma, or one of
/// the words for values that are not finite.
bool is_like_number(std::string_view field) {
  if (is_number(field) || !with_decimal_point(field).empty()) return true;
  field.remove_prefix(std::min(field.find_first_not_of("+-"), field.size()));
  const std::string word = lower_case(field);
  return word == "nan" || word == "inf" || word == "infinity";
}

/// Returns the fields of a row. Quotes count as blanks, because errors have no place here.
Words fields_of(std::string_view row, char separator) {
  if (row.find('"') != std::string_view::npos) {
    return words_of(row, std::string("\"") + separator + " \t");
  }
  Words fields;
  const FilePlace unused;
  FieldSplitter(separator).split(row, unused, fields);
  while (!fields.empty() && fields.back().empty()) fields.pop_back();  // "1,2,3,"
  return fields;
}

bool are_numbers(const Words& fields) {
  return fields.size() >= least_numbers && std::ranges::all_of(fields, is_like_number);
}

/// Returns the separator that makes the row a row of numbers. Returns nothing if none does.
std::optional<char> separator_of_numbers(std::string_view row) {
  for (const char separator : {';', '\t', ',', blank_separator}) {
    if (are_numbers(fields_of(row, separator))) return separator;
  }
  return {};
}

bool has_numbers(std::string_view row, char separator, std::size_t columns) {
  const Words fields = fields_of(row, separator);
  return fields.size() == columns && are_numbers(fields);
}

/// Returns whether the rows after a count may also be those of XYZ with a comment of numbers:
/// atomic numbers, each with a position.
bool may_be_xyz(const std::vector<Line>& rows, char separator, std::size_t columns) {
  if (rows.size() < 3) return false;
  return columns > least_numbers && std::all_of(rows.begin() + 2, rows.end(), [&](const Line& row) {
           const Words fields = fields_of(row.text, separator);
           return !fields.empty() && is_natural(fields[0]);
         });
}

/// Returns whether the first of `rows` is the number of the others, which have `columns` numbers.
bool is_counted(const FileStart& start, const std::vector<Line>& rows, char separator,
                std::size_t columns) {
  if (rows.size() < 2 || rows[1].place != rows[0].place + 1) return false;
  if (rows.size() > 2 && !has_numbers(rows[2].text, separator, columns)) return false;
  if (!may_be_xyz(rows, separator, columns)) return true;
  return start.whole() && natural_in(rows[0].text) == rows.size() - 1;
}

/// Recognises the header that pandas writes for columns without names: 0, 1, 2 and so on, maybe
/// after the empty name of an index. Describes the table in `shape`. Returns false for another row.
bool has_numbered_header(const std::vector<Line>& rows, TableShape& shape) {
  if (rows.size() < 2 || rows[0].text.find('"') != std::string_view::npos) return false;
  const char separator = separator_of(rows[0].text);
  if (separator == blank_separator) return false;
  Words names;
  const FilePlace unused;
  FieldSplitter(separator).split(rows[0].text, unused, names);
  const std::size_t index = names[0].empty() ? 1 : 0;
  for (std::size_t i = index; i < names.size(); ++i) {
    if (names[i] != std::to_string(i - index)) return false;
  }
  const std::size_t columns = names.size() - index;
  const Words fields = fields_of(rows[1].text, separator);
  const bool fits = fields.size() == names.size() && are_numbers(fields);
  const bool whole = std::ranges::all_of(fields, is_natural);
  if (columns < least_numbers || !fits || (index == 0 && whole)) return false;
  shape.names = TableShape::Names::none;
  shape.separator = separator;
  shape.numbered = shape.certain = true;
  shape.first = index;
  shape.columns = columns;
  return true;
}

std::string_view without_marks(std::string_view comment) {
  return comment.substr(std::min(comment.find_first_not_of("#/% \t"), comment.size()));
}

/// Returns the names in a comment, without its marks: "# x y z", "//X Y Z", "# columns: x y z".
Words words_of_comment(std::string_view comment, std::size_t columns) {
  comment = without_marks(comment);
  const std::size_t colon = comment.find(": ");
  Words words = words_of_header(comment);
  if (words.size() != columns && colon != std::string_view::npos) {
    words = words_of_header(trimmed(comment.substr(colon + 1)));
  }
  return words;
}

/// Finds names of positions, or of sky coordinates, in the last comment that has as many words as
/// the rows have columns. The next comment may have units.
void find_names(const std::vector<Line>& comments, TableShape& shape) {
  for (std::size_t i = comments.size(); i-- > 0;) {
    const Words words = words_of_comment(comments[i].text, shape.columns);
    if (words.size() != shape.columns) continue;
    TableNames names = table_names(words);
    if (!names.has_positions && sky_angles(names)[0].empty()) continue;
    if (i + 1 < comments.size()) {
      const std::string_view units = comments[i + 1].text;
      if (!take_units(words_of_comment(units, shape.columns), names)) {
        take_units(words_of(without_marks(units)), names);  // "m m m [m/s]"
      }
    }
    shape.names = TableShape::Names::comment;
    shape.comment = std::move(names);
    shape.line = comments[i].place + 1;
    return;
  }
}

/// Returns the value of a key in a line of YAML: {name: x, unit: pc}.
std::string_view yaml_value(std::string_view line, std::string_view key) {
  const std::size_t at = line.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = line.substr(at + key.size());
  const bool quoted = value.starts_with('"') || value.starts_with('\'');
  if (!quoted) return trimmed(value.substr(0, value.find_first_of(",}")));
  value.remove_prefix(1);
  return value.substr(0, value.find_first_of("\"'"));
}

/// Returns the units in a header of astropy's ECSV: "# - {name: x, unit: pc, datatype: float64}".
std::vector<std::pair<std::string, std::string>> units_of_ecsv(const std::vector<Line>& comments) {
  std::vector<std::pair<std::string, std::string>> units;
  for (const Line& comment : comments) {
    const std::string_view name = yaml_value(comment.text, "{name: ");
    const std::string_view unit = yaml_value(comment.text, "unit: ");
    if (!name.empty() && !unit.empty()) units.emplace_back(name, unit);
  }
  return units;
}

}  // namespace

TableShape table_shape(const FileStart& start) {
  const Lines lines = lines_of(start);
  TableShape shape;
  shape.units = units_of_ecsv(lines.comments);
  const std::vector<Line>& rows = lines.rows;
  if (rows.empty()) return shape;
  const std::size_t row = is_natural(rows[0].text) && rows.size() > 1 ? 1 : 0;
  if (has_numbered_header(rows, shape)) return shape;
  const std::optional<char> separator = separator_of_numbers(rows[row].text);
  if (!separator) {
    shape.separator = separator_of(rows[0].text);
    shape.certain = table_names(words_of_header(rows[0].text)).has_positions;
    return shape;
  }
  shape.separator = *separator;
  shape.columns = fields_of(rows[row].text, *separator).size();
  shape.counted = row == 1;
  if (shape.counted && !is_counted(start, rows, *separator, shape.columns)) return {};
  shape.names = TableShape::Names::none;
  shape.certain = std::all_of(
      rows.begin() + static_cast<std::ptrdiff_t>(row), rows.end(),
      [&](const Line& line) { return has_numbers(line.text, *separator, shape.columns); });
  find_names(lines.comments, shape);
  return shape;
}

bool is_counted_table(const FileStart& start) {
  const TableShape shape = table_shape(start);
  return shape.counted && shape.certain;
}

}  // namespace parray::input
