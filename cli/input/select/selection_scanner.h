#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// The words, signs and numbers of a selection's text, from front to back. What is a word depends
/// on whether names are being listed, so whoever reads asks for what may come. Blanks before it
/// are passed over.
class SelectionScanner {
 public:
  /// The text must outlive this.
  explicit SelectionScanner(std::string_view text) : text_(text) {}

  /// Where the next word begins: a byte of the text, and a character from 1.
  std::size_t next();
  std::size_t column();
  bool at_end() { return next() == text_.size(); }

  bool next_is(std::string_view sign);
  bool next_is_digit();
  bool next_is_letter();
  bool take_sign(std::string_view sign);
  /// `known` is in lower case; what is taken may be in any.
  bool take_word(std::string_view known);
  /// Fails unless that word comes: "'of' is missing: write FORM".
  void expect_word(std::string_view known, std::string_view form);

  /// A word in lower case, with the index that LAMMPS writes: c_stress[1]. A letter comes next.
  std::string word();
  /// A finite number. A digit or a point comes next.
  double number();
  /// What stands in double quotes, which come next.
  std::string quoted();
  /// The next of a list of names, which blanks and commas separate; nothing at its end.
  std::optional<std::string> name();

  /// What stands at byte `at`, for messages.
  [[nodiscard]] std::string shown(std::size_t at) const;
  /// Throws InputError "column N: PROBLEM", the first for what stands at byte `at`.
  [[noreturn]] void fail(std::size_t at, const std::string& problem) const;
  [[noreturn]] static void fail_at_column(std::size_t column, const std::string& problem);
  [[nodiscard]] std::size_t column_of(std::size_t at) const;

 private:
  [[nodiscard]] char here() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  [[nodiscard]] std::size_t end_of_name(std::size_t at) const;

  std::string_view text_;
  std::size_t at_ = 0;
  // The column that was asked for last: the next lies a little farther on, mostly.
  mutable std::size_t known_at_ = 0;
  mutable std::size_t known_characters_ = 0;
};

}  // namespace parray::input
