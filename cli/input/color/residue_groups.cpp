#include "cli/input/color/residue_groups.h"

#include <algorithm>
#include <array>
#include <string>

#include "cli/input/particles/residues.h"

namespace parray::input {
namespace {

struct ResidueGroup {
  std::string_view name;
  std::string_view residues;  ///< between blanks
};

/// Acids are red and bases blue, as charges are drawn.
constexpr std::array<ResidueGroup, 11> group_table{
    {{"glycine, proline, cysteine", " GLY PRO HYP CYS CYX CYM CYSH CYS1 CYS2 SEC "},
     {"polar", " SER THR ASN GLN "},
     {"aliphatic", " ALA VAL LEU ILE MET MSE NLE AIB "},
     {"aromatic", " PHE TYR TRP "},
     {"positive",
      " LYS ARG HIS LYN LYP LYSH LSN ARGN ARN HID HIE HIP HSD HSE HSP HISA HISB HISD HISE HISH "},
     {"negative", " ASP GLU ASH ASPH ASPP GLH GLUH GLUP "},
     {"adenine", " A DA RA ADE "},
     {"guanine", " G DG RG GUA "},
     {"cytosine", " C DC RC CYT "},
     {"thymine, uracil", " T U DT DU RU THY URA "},
     {"water", ""}}};
constexpr std::size_t water_group = group_table.size() - 1;

constexpr std::array<std::string_view, group_table.size()> group_names = [] {
  std::array<std::string_view, group_table.size()> names;
  std::ranges::transform(group_table, names.begin(), &ResidueGroup::name);
  return names;
}();

std::optional<std::size_t> group_that_lists(std::string_view name) {
  const std::string word = " " + std::string(name) + " ";
  const auto found = std::ranges::find_if(group_table, [&](const ResidueGroup& group) {
    return group.residues.find(word) != std::string_view::npos;
  });
  if (found == group_table.end()) return {};
  return static_cast<std::size_t>(found - group_table.begin());
}

}  // namespace

std::span<const std::string_view> residue_groups() { return group_names; }

std::optional<std::size_t> residue_group(std::string_view residue_name) {
  if (is_water(residue_name)) return water_group;
  std::string name(residue_name);
  std::ranges::transform(name, name.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  });
  if (const auto group = group_that_lists(name)) return group;
  // AMBER's ends of chains.
  if (is_amino_acid(name) && name.size() == 4) return group_that_lists(name.substr(1));
  if (is_nucleotide(name)) return group_that_lists(name.substr(0, name.size() - 1));
  return {};
}

}  // namespace parray::input
