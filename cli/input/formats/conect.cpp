#include "cli/input/formats/conect.h"

#include <algorithm>

#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::size_t serial_width = 5;

/// Returns the serial number of an atom: the first word after "ATOM" or "HETATM".
std::string_view serial_of(std::string_view record) {
  const std::size_t name = ascii::lower(record[0]) == 'h' ? 6 : 4;
  const std::string_view rest = record.substr(std::min(name, record.size()));
  const std::size_t begin = std::min(rest.find_first_not_of(" \t"), rest.size());
  return rest.substr(begin, rest.find_first_of(" \t", begin) - begin);
}

/// Returns the serial numbers in the text after the name CONECT. In columns, numbers stand on the
/// right.
std::vector<std::string_view> serials_in(std::string_view text) {
  constexpr std::size_t most = 5;
  std::vector<std::string_view> words;
  split_at_blanks(text, words);
  const bool in_columns = std::ranges::all_of(words, [&](std::string_view word) {
    return static_cast<std::size_t>(word.data() - text.data() + std::ssize(word)) % serial_width ==
           0;
  });
  if (!in_columns) return words;
  words.clear();
  for (std::size_t i = 0; i < most && i * serial_width < text.size(); ++i) {
    words.push_back(field_at(text, i * serial_width, serial_width));
  }
  return words;
}

}  // namespace

void ConectBonds::add_atom(std::string_view record) {
  serials_.add(serial_number_in(serial_of(record)));
}

void ConectBonds::read(std::string_view record) {
  constexpr std::size_t name_width = 6;
  if (record.size() <= name_width) return;
  const std::vector<std::string_view> serials = serials_in(record.substr(name_width));
  const auto first = serials.empty() ? std::nullopt : serial_number_in(serials[0]);
  if (!first) return;
  for (std::size_t i = 1; i < serials.size(); ++i) {
    const auto other = serial_number_in(serials[i]);
    if (other) pairs_.emplace_back(std::min(*first, *other), std::max(*first, *other));
  }
}

void ConectBonds::finish(AtomColumns& atoms) {
  std::ranges::sort(pairs_);
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  std::uint64_t left_out = 0;
  for (const auto& [one, other] : pairs_) {
    const auto first = serials_.find(one);
    const auto second = serials_.find(other);
    if (first && second && *first != *second) {
      atoms.bond(*first, *second);
    } else {
      ++left_out;
    }
  }
  if (left_out > 0) atoms.note(unknown_bonds_note(left_out));
  clear();
}

void ConectBonds::clear() {
  serials_.clear();
  pairs_.clear();
}

}  // namespace parray::input
