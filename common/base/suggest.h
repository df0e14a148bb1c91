#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Finds the known word that somebody who wrote `word` may have meant.
///
/// Near is: few insertions, deletions, substitutions and swaps of neighbours, letter case aside
/// (optimal string alignment distance; at most a third of the word's length, and at least one).
/// Of equally near words the first offered wins. The words are copied; nothing else is kept.
class NearestWord {
 public:
  explicit NearestWord(std::string_view word);

  void offer(std::string_view known);

  /// The nearest word offered so far; empty when none is near.
  const std::string& best() const { return best_; }

 private:
  std::string word_;
  std::string best_;
  std::size_t limit_;  // a word must be nearer than this to become the best
};

/// What to do about the unknown name `word`, as the end of a message: "did you mean 'vfov'?" or,
/// when nothing is near, "known: look_from, look_at".
std::string remedy_for_name(std::string_view word, std::span<const std::string_view> known);

/// "a, b, c".
std::string list_names(std::span<const std::string_view> names);

}  // namespace parray::base
