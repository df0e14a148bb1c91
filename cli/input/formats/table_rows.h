#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particle_input.h"

/// Lines and fields of a text table.
namespace parray::input {

/// Returns whether a line is a comment: it begins with #, // or %.
bool is_table_comment(std::string_view line);

/// Means that any number of blanks and tabs separates two fields.
inline constexpr char blank_separator = ' ';

/// Splits lines at a separator. Removes quotes and blanks around fields. A quote within quotes is
/// written twice.
class FieldSplitter {
 public:
  /// `separator`: a character, or blank_separator.
  explicit FieldSplitter(char separator) : separator_(separator) {}

  /// Replaces `fields` by those of `line`. They are valid until the next call, as long as `line`
  /// is. Throws InputError at `place` for a quote that is not closed, and for text after a closing
  /// quote.
  void split(std::string_view line, const FilePlace& place, std::vector<std::string_view>& fields);

 private:
  void split_plain(std::string_view line, std::vector<std::string_view>& fields) const;
  void split_quoted(std::string_view line, const FilePlace& place,
                    std::vector<std::string_view>& fields);
  [[nodiscard]] std::size_t end_of_field(std::string_view rest) const;
  void take_quoted(std::string_view& rest, std::size_t& filled, const FilePlace& place);

  char separator_;
  std::string text_;
};

/// Returns the first comma, semicolon or tab outside quotes. Returns blank_separator if there is
/// none.
char separator_of(std::string_view header);

/// Replaces decimal commas by points.
class DecimalCommas {
 public:
  /// Changes fields such as "1,5" to "1.5", if they are numbers then. The fields are valid until
  /// the next call. Throws InputError at `place` if the table has decimal commas and decimal
  /// points.
  void replace(const FilePlace& place, std::vector<std::string_view>& fields);

  /// Returns the number of the first line with a decimal comma; 0: none.
  [[nodiscard]] std::uint64_t first_line() const { return comma_line_; }

 private:
  std::string text_;
  std::uint64_t comma_line_ = 0;
  std::uint64_t point_line_ = 0;
};

/// Returns the field with a point in place of its only comma, if that is a number. Otherwise
/// returns an empty text.
std::string with_decimal_point(std::string_view field);

/// The rows of a table. Skips blank lines and comments. Accepts decimal commas unless the separator
/// is a comma.
class TableRows {
 public:
  TableRows(ParticleInput& input, char separator)
      : input_(&input), splitter_(separator), separator_(separator) {}

  /// Goes to the next line with a row. Returns false at the end of the file.
  bool next_line();
  /// Returns the fields of the line. They are valid until the next call. Throws the errors of
  /// FieldSplitter::split() and DecimalCommas::replace().
  [[nodiscard]] const std::vector<std::string_view>& split();
  /// Goes to the next row and splits it. Returns nullptr at the end of the file.
  const std::vector<std::string_view>* next() { return next_line() ? &split() : nullptr; }

  [[nodiscard]] bool has_decimal_commas() const { return commas_.first_line() > 0; }

 private:
  ParticleInput* input_;
  FieldSplitter splitter_;
  char separator_;
  DecimalCommas commas_;
  std::vector<std::string_view> fields_;
};

}  // namespace parray::input
