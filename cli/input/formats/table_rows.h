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

/// Returns the field with a point in place of its only comma, if that is a number. Otherwise
/// returns an empty text.
std::string with_decimal_point(std::string_view field);

/// The rows of a table. Skips blank lines and comments. Unless the separator is a comma, changes
/// fields such as "1,5" to "1.5" if they are numbers then.
class TableRows {
 public:
  TableRows(ParticleInput& input, char separator)
      : input_(&input), splitter_(separator), separator_(separator) {}

  /// Goes to the next line with a row. Returns false at the end of the file.
  bool next_line();
  /// Goes to the next row. Returns its fields, which are valid until the next call, or nullptr at
  /// the end of the file. Throws the errors of FieldSplitter::split(). Throws InputError if the
  /// table has decimal commas and decimal points.
  const std::vector<std::string_view>* next();

  [[nodiscard]] bool has_decimal_commas() const { return comma_line_ > 0; }

 private:
  void replace_commas();

  ParticleInput* input_;
  FieldSplitter splitter_;
  char separator_;
  std::vector<std::string_view> fields_;
  std::string text_;              // fields with points in place of commas
  std::uint64_t comma_line_ = 0;  // first line with a decimal comma; 0: none
  std::uint64_t point_line_ = 0;  // first line with a decimal point
};

}  // namespace parray::input
