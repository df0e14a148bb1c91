#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Reads the words, signs and numbers of a selection from front to back. The parser asks for one
/// kind at a time, because the meaning of a word depends on the context. All members that read skip
/// blanks first.
class SelectionScanner {
 public:
  /// The text must outlive this object.
  explicit SelectionScanner(std::string_view text) : text_(text) {}

  /// Return the start of the next word: its byte offset, and its column (characters from 1).
  std::size_t next();
  std::size_t column();
  bool at_end() { return next() == text_.size(); }

  bool next_is(std::string_view sign);
  bool next_is_digit();   ///< a digit or a decimal point
  bool next_is_letter();  ///< A to Z, a to z or '_'
  /// Takes the sign if it comes next. Returns whether it did.
  bool take_sign(std::string_view sign);
  /// Takes the word `known` (lower case) if it comes next, in any letter case. Returns whether it
  /// did.
  bool take_word(std::string_view known);
  /// Takes the word `known`. Otherwise throws InputError "'of' is missing: write FORM".
  void expect_word(std::string_view known, std::string_view form);

  /// Returns a word in lower case, with the index that LAMMPS writes: c_stress[1]. A letter must
  /// come next.
  std::string word();
  /// Returns a finite number. A digit or a point must come next.
  double number();
  /// Returns a text in double quotes, which must come next.
  std::string quoted();
  /// Returns the next name of a list with blanks or commas. Returns nothing at the end of the list,
  /// such as before `and`, `or` and `not`.
  std::optional<std::string> name();

  /// Returns the text at byte `at` in a form for messages.
  [[nodiscard]] std::string shown(std::size_t at) const;
  /// Throw InputError "character N: PROBLEM". The first takes byte `at`, the second the column.
  [[noreturn]] void fail(std::size_t at, const std::string& problem) const;
  [[noreturn]] static void fail_at_column(std::size_t column, const std::string& problem);
  /// Returns the column of byte `at`.
  [[nodiscard]] std::size_t column_of(std::size_t at) const;

 private:
  [[nodiscard]] char here() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  [[nodiscard]] std::size_t end_of_name(std::size_t at) const;

  std::string_view text_;
  std::size_t at_ = 0;
  // Cache of the last column_of(): the next call usually asks for a place shortly after it.
  mutable std::size_t known_at_ = 0;
  mutable std::size_t known_characters_ = 0;
};

}  // namespace parray::input
