#include "cli/input/formats/alternative_locations.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

namespace parray::input {
namespace {

/// Chain, number and insertion code.
using ResidueKey = std::tuple<std::uint32_t, std::int32_t, char>;

ResidueKey residue_of(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                      std::size_t i) {
  return {atoms.chains[i], atoms.residue_numbers[i], alternatives.insertions.at(i)};
}

/// The best of those that have been offered.
class Best {
 public:
  Best(const AlternativeChoice& choice) : choice_(choice) {}

  void offer(char letter, float occupancy, std::uint32_t value) {
    const bool wanted = choice_.rule == AlternativeChoice::Rule::letter && letter == choice_.letter;
    const bool better = wanted != wanted_ ? wanted : occupancy > occupancy_;
    if (!any_ || better) {
      value_ = value;
      occupancy_ = occupancy;
      wanted_ = wanted;
    }
    any_ = true;
  }
  [[nodiscard]] std::uint32_t value() const { return value_; }

 private:
  AlternativeChoice choice_;
  bool any_ = false;
  bool wanted_ = false;
  float occupancy_ = 0;
  std::uint32_t value_ = 0;
};

/// One choice for each key, of the values that its particles offer.
template <typename Key>
class Choices {
 public:
  explicit Choices(const AlternativeChoice& choice) : choice_(choice) {}

  void offer(const Key& key, const AlternativeColumns& columns, std::size_t i,
             std::uint32_t value) {
    chosen_.try_emplace(key, choice_)
        .first->second.offer(columns.letters.at(i), columns.occupancies.at(i), value);
  }
  [[nodiscard]] bool has(const Key& key) const { return chosen_.contains(key); }
  [[nodiscard]] std::uint32_t of(const Key& key) const { return chosen_.at(key).value(); }

 private:
  AlternativeChoice choice_;
  std::map<Key, Best> chosen_;
};

/// The doubtful atoms from `begin` on that stand together in one residue of one name.
std::size_t run_end(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                    std::size_t begin) {
  const auto& doubtful = alternatives.doubtful;
  const auto& names = atoms.residue_names.column().index;
  const ResidueKey residue = residue_of(alternatives, atoms, doubtful[begin]);
  std::size_t end = begin + 1;
  while (end < doubtful.size() && doubtful[end] == doubtful[end - 1] + 1 &&
         residue_of(alternatives, atoms, doubtful[end]) == residue &&
         names[doubtful[end]] == names[doubtful[begin]]) {
    ++end;
  }
  return end;
}

/// Whether `other` is an atom of the same residue as `particle`.
bool same_residue(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                  std::size_t particle, std::size_t other) {
  const auto& names = atoms.residue_names.column().index;
  return other < names.size() && names[other] == names[particle] &&
         residue_of(alternatives, atoms, other) == residue_of(alternatives, atoms, particle);
}

bool are_locations(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                   std::size_t first, std::size_t last) {
  if (same_residue(alternatives, atoms, first, last + 1)) return true;
  if (first > 0 && same_residue(alternatives, atoms, first, first - 1)) return true;
  const char letter = alternatives.letters.at(first);
  for (std::size_t i = first; i <= last; ++i) {
    const float occupancy = alternatives.occupancies.at(i);
    if (alternatives.letters.at(i) != letter || (occupancy > 0 && occupancy < 1)) return true;
  }
  return false;
}

}  // namespace

void settle_doubtful(AlternativeColumns& alternatives, const AtomIdentity& atoms) {
  const auto& doubtful = alternatives.doubtful;
  for (std::size_t begin = 0; begin < doubtful.size();) {
    const std::size_t end = run_end(alternatives, atoms, begin);
    const std::size_t first = doubtful[begin];
    const std::size_t last = doubtful[end - 1];
    begin = end;
    if (are_locations(alternatives, atoms, first, last)) continue;
    const auto& names = atoms.residue_names.column();
    const std::string name = alternatives.letters.at(first) + names.of(first);
    for (std::size_t i = first; i <= last; ++i) {
      atoms.residue_names.rename(i, name);
      alternatives.letters.reset(i);
    }
  }
  if (!doubtful.empty()) atoms.residue_names.drop_unused();
}

ParticleMask chosen_locations(const AlternativeColumns& alternatives, const AtomIdentity& atoms,
                              const AlternativeChoice& choice) {
  using AtomKey = std::tuple<ResidueKey, std::uint32_t, std::uint32_t>;
  const auto& names = atoms.residue_names.column().index;
  const std::size_t count = names.size();
  const auto key_of = [&](const ResidueKey& residue, std::size_t i) {
    return AtomKey{residue, names[i], atoms.atom_names[i]};
  };
  Choices<ResidueKey> residues(choice);  // the name's number
  for (std::size_t i = 0; i < count; ++i) {
    if (alternatives.letters.at(i) == ' ') continue;
    residues.offer(residue_of(alternatives, atoms, i), alternatives, i, names[i]);
  }
  Choices<AtomKey> locations(choice);  // the letter
  for (std::size_t i = 0; i < count; ++i) {
    const ResidueKey residue = residue_of(alternatives, atoms, i);
    if (!residues.has(residue)) continue;
    locations.offer(key_of(residue, i), alternatives, i,
                    static_cast<unsigned char>(alternatives.letters.at(i)));
  }
  ParticleMask mask(count, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const ResidueKey residue = residue_of(alternatives, atoms, i);
    if (!residues.has(residue)) continue;
    const auto letter = static_cast<unsigned char>(alternatives.letters.at(i));
    const bool other_residue = letter != ' ' && names[i] != residues.of(residue);
    if (other_residue || locations.of(key_of(residue, i)) != letter) mask[i] = 0;
  }
  return mask;
}

}  // namespace parray::input
