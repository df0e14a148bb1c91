#include "common/base/suggest.h"

#include <algorithm>
#include <vector>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::base {
namespace {

// Longest compared word: the cost is quadratic, and a longer word is hardly a mistyped name.
constexpr std::size_t max_word = 64;

/// Returns the optimal string alignment distance (Damerau 1964, each swapped pair edited once).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1);
  std::vector<std::size_t> above(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, above);
    std::swap(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({change, above[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
  }
  return row[b.size()];
}

}  // namespace

NearestWord::NearestWord(std::string_view word)
    : word_(lower_case(word.substr(0, max_word + 1))),
      limit_(word_.size() > max_word ? 0 : std::max<std::size_t>(1, word_.size() / 3) + 1) {}

void NearestWord::offer(std::string_view known) {
  // The difference in length is a lower bound of the distance.
  const std::size_t difference =
      std::max(known.size(), word_.size()) - std::min(known.size(), word_.size());
  if (known.empty() || known.size() > max_word || difference >= limit_) return;
  const std::size_t distance = edit_distance(word_, lower_case(known));
  if (distance >= limit_) return;
  limit_ = distance;
  best_ = known;
}

std::string remedy_for_name(std::string_view word, std::span<const std::string_view> known) {
  NearestWord nearest(word);
  for (const std::string_view name : known) nearest.offer(name);
  if (nearest.best().empty()) return "known: " + list_names(known);
  return "did you mean '" + printable(nearest.best()) + "'?";
}

std::size_t known_place(std::string_view what, std::string_view word,
                        std::span<const std::string_view> known) {
  if (const auto place = place_in(known, word)) return *place;
  throw InputError("unknown " + std::string(what) + " '" + printable(word) +
                   "': " + remedy_for_name(word, known));
}

std::string list_names(std::span<const std::string_view> names) {
  std::string out;
  for (const std::string_view name : names) {
    if (!out.empty()) out += ", ";
    out += printable(name);
  }
  return out;
}

}  // namespace parray::base
