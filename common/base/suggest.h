#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Finds the known word that a user may have meant by `word`.
///
/// A known word is near if few edits separate both: insertions, deletions, substitutions and swaps
/// of neighbours, ignoring letter case (optimal string alignment distance). The limit is a third of
/// the length of `word`, and at least one edit. No known word is near to a `word` of more than 64
/// bytes. The first of equally near words wins. The object keeps copies of words, no references.
class NearestWord {
 public:
  explicit NearestWord(std::string_view word);

  /// Compares the next known word with `word`.
  void offer(std::string_view known);

  /// Returns the nearest word offered so far; empty if none is near.
  const std::string& best() const { return best_; }

 private:
  std::string word_;
  std::string best_;
  std::size_t limit_;  // a word must be nearer than this to become the best
};

/// Returns the remedy for the unknown name `word`, as the end of a message: "did you mean 'vfov'?"
/// or, if no name is near, "known: look_from, look_at".
std::string remedy_for_name(std::string_view word, std::span<const std::string_view> known);

/// Returns the index of `word` in `known`. If `word` is missing there, throws InputError "unknown
/// WHAT 'WORD': " with remedy_for_name() at the end.
std::size_t known_place(std::string_view what, std::string_view word,
                        std::span<const std::string_view> known);

/// Returns the names in the form "a, b, c", each as printable() returns it.
std::string list_names(std::span<const std::string_view> names);

}  // namespace parray::base
