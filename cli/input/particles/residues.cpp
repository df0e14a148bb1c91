#include "cli/input/particles/residues.h"

#include <algorithm>
#include <array>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "cli/input/particles/elements.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

using Names = std::unordered_set<std::string_view>;

/// A name in upper case, without blanks. Names that are longer than any known name become empty.
class Upper {
 public:
  explicit Upper(std::string_view name) {
    for (const char c : name) {
      if (c == ' ') continue;
      if (size_ == text_.size()) {
        size_ = 0;
        return;
      }
      text_[size_++] = ascii::upper(c);
    }
  }
  [[nodiscard]] std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, 8> text_{};
  std::size_t size_ = 0;
};

const Names& waters() {
  static const Names names{
      "HOH",  "WAT",  "H2O",   "SOL",  "DOD",  "D2O",   "HHO",   "OHH",   "HH0",  "OH2",  "TIP",
      "TIP2", "TIP3", "TIP4",  "TIP5", "TIPS", "TP3",   "TP4",   "TP5",   "TP3M", "T3H",  "T3P",
      "T4P",  "T4E",  "T4I",   "T5P",  "T3PF", "TIP3P", "TIP4P", "TIP5P", "SPC",  "SPCE", "SPCF",
      "SPE",  "SPF",  "SPCFW", "OPC",  "OPC3", "PL3",   "POL3",  "SWM4",  "SWM6", "SWM"};
  return names;
}

const Names& amino_acids() {
  static const Names names{
      // The genetic code, and the ambiguous residues of PDB.
      "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET",
      "PHE", "PRO", "SER", "THR", "TRP", "TYR", "VAL", "SEC", "PYL", "ASX", "GLX", "XLE", "UNK",
      // Protonation states and bridges: AMBER, CHARMM, OPLS, GROMOS.
      "HID", "HIE", "HIP", "HSD", "HSE", "HSP", "HIS1", "HIS2", "HISA", "HISB", "HISD", "HISE",
      "HISH", "HISP", "HYP", "CYX", "CYM", "CYN", "CYS1", "CYS2", "CYSH", "CYSX", "ASH", "ASPH",
      "ASPP", "GLH", "GLUH", "GLUP", "LYN", "LYP", "LYSH", "LSN", "ARGN", "ARN", "TYM", "NLE",
      "DAB", "ORN", "AIB",
      // Modified amino acids.
      "MSE", "SEP", "TPO", "PTR", "SP2", "TP2", "CSO", "CSD", "CSX", "CME", "OCS", "KCX", "LLP",
      "MLY", "MLZ", "M3L", "PCA", "CGU", "TYS", "ALY", "CAS", "FME", "HIC", "NEP", "SCH", "SMC",
      "MHO", "CRO",
      // D-amino acids.
      "DAL", "DAR", "DSG", "DAS", "DCY", "DGL", "DGN", "DHI", "DIL", "DLE", "DLY", "MED", "DPN",
      "DPR", "DSN", "DTH", "DTR", "DTY", "DVA",
      // Caps of chains.
      "ACE", "NME", "NMA", "NAC", "NH2", "NHE", "FOR", "CT1", "CT2", "CT3"};
  return names;
}

const Names& nucleotides() {
  static const Names names{"A",   "C",   "G",   "U",   "T",   "I",   "N",   "DA",  "DC",  "DG",
                           "DT",  "DU",  "DI",  "DN",  "RA",  "RC",  "RG",  "RU",  "RI",  "ADE",
                           "CYT", "GUA", "URA", "THY", "PSU", "5MU", "5MC", "7MG", "1MA", "2MG",
                           "M2G", "OMC", "OMG", "OMU", "H2U", "4SU", "YYG", "YG",  "1MG", "6MA",
                           "6MZ", "A2M", "MA6", "5BU", "5CM", "8OG"};
  return names;
}

/// Names of ions that differ from the element's symbol with or without a charge.
const std::unordered_map<std::string_view, std::uint8_t>& ions() {
  static const std::unordered_map<std::string_view, std::uint8_t> names{
      {"LIT", 3},  {"SOD", 11}, {"CIO", 11}, {"POT", 19}, {"RUB", 37}, {"CES", 55},
      {"CLA", 17}, {"CHL", 17}, {"CIM", 17}, {"CAL", 20}, {"MGH", 12}, {"MGA", 12},
      {"BAR", 56}, {"CAD", 48}, {"IOD", 53}, {"BRO", 35}, {"FLA", 9},  {"FE2", 26},
      {"CU1", 29}, {"3CO", 27}, {"3NI", 28}, {"4MO", 42}, {"YT3", 39}, {"AU3", 79},
      {"ZN2", 30}, {"MN3", 25}, {"IUM", 92}, {"FEL", 26}, {"AU1", 79}, {"ION", 0}};
  return names;
}

/// Returns whether an element forms monatomic ions in solutions and crystals of molecules.
bool makes_ions(std::uint8_t element) {
  constexpr std::array<std::uint8_t, 36> elements{3,  9,  11, 12, 13, 17, 19, 20, 24, 25, 26, 27,
                                                  28, 29, 30, 31, 33, 35, 37, 38, 39, 46, 47, 48,
                                                  53, 55, 56, 57, 62, 63, 64, 78, 79, 80, 81, 82};
  return std::ranges::find(elements, element) != elements.end();
}

bool is_charge(char c) { return ascii::is_digit(c) || c == '+' || c == '-'; }

/// Removes the charge at the end of a name: "NA+", "CL-1", "MG2+", "ZN2".
std::string_view without_charge(std::string_view name) {
  while (!name.empty() && is_charge(name.back())) name.remove_suffix(1);
  return name;
}

/// Sites of water models other than O and H, and Drude particles.
const Names& water_sites() {
  static const Names names{"MW",  "MW1", "MW2", "MW4", "M",   "M1",  "M2",  "OM",  "IW",  "EPW",
                           "EP",  "EP1", "EP2", "LP",  "LP1", "LP2", "LPA", "LPB", "L1",  "L2",
                           "LW1", "LW2", "LA",  "LB",  "VS",  "X",   "XX",  "DUM", "DOH2"};
  return names;
}

/// Returns whether `name` is `stem` followed only by digits, at least `digits` of them.
bool is_numbered(std::string_view name, std::string_view stem, std::size_t digits = 0) {
  return name.starts_with(stem) && name.size() >= stem.size() + digits &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(stem.size()), name.end(),
                     ascii::is_digit);
}

/// GROMACS: returns true for the centres of mass that carry rigid CH3, NH3 and CH2 groups and
/// rings.
bool is_mass_center(std::string_view name) {
  return name.starts_with("MC") || name.starts_with("MN") || is_numbered(name, "MW", 1);
}

/// X-PLOR: returns true for the mean of hydrogens that spectra cannot distinguish: "QB", "QG1",
/// "QQD".
bool is_pseudo_atom(std::string_view name) { return name.starts_with('Q'); }

/// Returns true for dummy atoms and lone pairs, including AutoDock's G0, which closes rings.
bool is_dummy(std::string_view name) {
  constexpr std::array<std::string_view, 8> stems{"LP", "EP", "DU", "DUM", "X", "XX", "VS", "G"};
  return std::ranges::any_of(stems, [&](auto stem) { return is_numbered(name, stem); }) ||
         name.starts_with("LP");
}

struct ResidueGroup {
  std::string_view name;
  std::string_view residues;  ///< names, separated and enclosed by blanks
};

/// Acids are red and bases are blue, the usual colours of charges.
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

bool is_water(std::string_view residue) { return waters().contains(Upper(residue).view()); }

bool is_amino_acid(std::string_view residue) {
  const Upper upper(residue);
  const std::string_view name = upper.view();
  if (amino_acids().contains(name)) return true;
  const bool end = name.size() == 4 && (name[0] == 'N' || name[0] == 'C');
  return end && amino_acids().contains(name.substr(1));
}

bool is_nucleotide(std::string_view residue) {
  const Upper upper(residue);
  std::string_view name = upper.view();
  if (nucleotides().contains(name)) return true;
  const bool end = name.size() > 1 && name.size() < 4 &&
                   (name.back() == '5' || name.back() == '3' || name.back() == 'N');
  if (end) name.remove_suffix(1);
  return end && nucleotides().contains(name);
}

std::uint8_t ion_element(std::string_view name) {
  const Upper upper(name);
  if (const auto known = ions().find(upper.view()); known != ions().end()) return known->second;
  const std::uint8_t element = atomic_number_of(without_charge(upper.view()));
  return makes_ions(element) ? element : 0;
}

bool is_ion(std::string_view residue, std::string_view atom) {
  if (Upper(residue).view() == "ION") return true;
  const std::uint8_t element = ion_element(residue);
  return element != 0 && element == ion_element(atom);
}

bool is_virtual_site(std::string_view residue, std::string_view atom, std::uint8_t element) {
  const Upper upper(atom);
  const std::string_view name = upper.view();
  if (Upper(residue).view() == "DUM") return true;
  if (is_water(residue)) return water_sites().contains(name);
  if (element != 0) return false;
  if (is_amino_acid(residue) && (is_mass_center(name) || is_pseudo_atom(name))) return true;
  return is_dummy(name);
}

std::span<const std::string_view> residue_groups() { return group_names; }

std::optional<std::size_t> residue_group(std::string_view residue_name) {
  if (is_water(residue_name)) return water_group;
  std::string name(residue_name);
  std::ranges::transform(name, name.begin(), ascii::upper);
  if (const auto group = group_that_lists(name)) return group;
  // Residue names of AMBER at the ends of chains.
  if (is_amino_acid(name) && name.size() == 4) return group_that_lists(name.substr(1));
  if (is_nucleotide(name)) return group_that_lists(name.substr(0, name.size() - 1));
  return {};
}

}  // namespace parray::input
