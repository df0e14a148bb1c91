#include "common/input/coloring/residue_groups.h"

#include <algorithm>
#include <array>

#include "common/input/selection/particle_classes.h"

namespace parray {
namespace {

/// Acids are red and bases blue, as charges are drawn.
constexpr std::array<std::string_view, 11> groups{"glycine, proline, cysteine",
                                                  "polar",
                                                  "aliphatic",
                                                  "aromatic",
                                                  "positive",
                                                  "negative",
                                                  "adenine",
                                                  "guanine",
                                                  "cytosine",
                                                  "thymine and uracil",
                                                  "water"};
constexpr std::size_t water = groups.size() - 1;

/// The group of each letter, of amino acids and of nucleotides.
constexpr std::array<std::string_view, 6> amino_acids_of{"GPCU", "STNQ", "AVLIM",
                                                         "FWY",  "KRHO", "DE"};
constexpr std::array<std::string_view, 4> bases_of{"A", "G", "C", "TU"};

template <std::size_t count>
std::optional<std::size_t> group_with(char letter, const std::array<std::string_view, count>& of) {
  const auto found = std::ranges::find_if(of, [letter](std::string_view letters) {
    return letters.find(letter) != std::string_view::npos;
  });
  if (found == of.end()) return {};
  return static_cast<std::size_t>(found - of.begin());
}

}  // namespace

std::span<const std::string_view> residue_groups() { return groups; }

std::optional<std::size_t> residue_group(std::string_view residue_name) {
  if (is_residue_of("water", residue_name)) return water;
  if (const char letter = amino_acid_letter(residue_name); letter != 0) {
    return group_with(letter, amino_acids_of);
  }
  const char base = nucleotide_letter(residue_name);
  const auto group = base == 0 ? std::nullopt : group_with(base, bases_of);
  if (!group) return {};
  return *group + amino_acids_of.size();
}

}  // namespace parray
