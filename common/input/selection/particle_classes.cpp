#include "common/input/selection/particle_classes.h"

#include <algorithm>
#include <array>
#include <span>

namespace parray {
namespace {

constexpr std::array<std::string_view, 9> waters{"HOH", "WAT",  "H2O",  "DOD", "SOL",
                                                 "TIP", "TIP3", "TIP4", "SPC"};
constexpr std::array<std::string_view, 26> amino_acids{
    "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET",
    "PHE", "PRO", "SER", "THR", "TRP", "TYR", "VAL", "MSE", "SEC", "HSD", "HSE", "HID", "HIE"};
constexpr std::array<std::string_view, 9> nucleotides{"A",  "C",  "G",  "U", "DA",
                                                      "DC", "DG", "DT", "T"};
constexpr std::array<std::string_view, 10> ion_names{"NA", "CL",  "K",   "MG",  "CA",
                                                     "ZN", "NA+", "CL-", "SOD", "CLA"};

}  // namespace

bool is_residue_of(std::string_view kind, std::string_view residue_name) {
  const auto in = [&](std::span<const std::string_view> names) {
    return std::ranges::find(names, residue_name) != names.end();
  };
  if (kind == "water") return in(waters);
  if (kind == "protein") return in(amino_acids);
  return kind == "nucleic" ? in(nucleotides) : in(ion_names);
}

char amino_acid_letter(std::string_view residue_name) {
  constexpr std::string_view letters = "ARNDCQEGHILKMFPSTWYVMUHHHH";
  const auto found = std::ranges::find(amino_acids, residue_name);
  return found == amino_acids.end()
             ? '\0'
             : letters[static_cast<std::size_t>(found - amino_acids.begin())];
}

char nucleotide_letter(std::string_view residue_name) {
  return is_residue_of("nucleic", residue_name) ? residue_name.back() : '\0';
}

ParticleMask virtual_sites(const Particles& particles) {
  static_cast<void>(particles);
  return {};
}

}  // namespace parray
