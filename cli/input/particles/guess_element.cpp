#include "cli/input/particles/guess_element.h"

#include <algorithm>
#include <array>
#include <string>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/residues.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

constexpr std::uint8_t selenium = 34;

/// From the first letter on: without blanks, the digits of "1HB2" and marks.
std::string_view from_letter(std::string_view name) {
  while (!name.empty() && !ascii::is_letter(name.front())) name.remove_prefix(1);
  return name;
}

/// The letters that a name starts with, in upper case.
std::string letters_of(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    if (!ascii::is_letter(c)) break;
    letters.push_back(ascii::upper(c));
  }
  return letters;
}

/// Of organic molecules, and deuterium.
std::uint8_t organic(char letter) {
  constexpr std::string_view symbols = "HDCNOSPFBI";
  return symbols.find(letter) == std::string_view::npos ? 0 : atomic_number_of({&letter, 1});
}

/// Symbols of two letters with which no usual name of an atom of C, H, N, O, P or S starts.
bool is_plain_pair(std::string_view letters) {
  constexpr std::array<std::string_view, 42> pairs{
      "CL", "BR", "LI", "BE", "AL", "SI", "AR", "TI", "MN", "MG", "FE", "NI", "CU", "ZN",
      "GA", "GE", "AS", "SE", "KR", "ZR", "MO", "RU", "RH", "AG", "TE", "XE", "PT", "AU",
      "IR", "RB", "TL", "GD", "LA", "EU", "YB", "LU", "TB", "BI", "BA", "RE", "TA", "IN"};
  return std::ranges::find(pairs, letters) != pairs.end();
}

/// "SC1" to "SC6" and "BB": side chain and backbone of models with few beads a residue.
bool is_bead(std::string_view letters, std::string_view name) {
  return letters == "BB" || (letters == "SC" && name.size() == 3);
}

/// In residues whose atoms are known: H, C, N, O, P, S, and selenium in place of sulphur.
std::uint8_t in_polymer(std::string_view name, const std::string& letters) {
  if (is_bead(letters, name)) return 0;
  if (letters.starts_with("SE")) return selenium;
  constexpr std::string_view symbols = "HDCNOSP";
  return symbols.find(letters[0]) == std::string_view::npos ? 0 : organic(letters[0]);
}

std::uint8_t pair_of(const std::string& letters) {
  return letters.size() < 2 ? 0 : atomic_number_of(std::string_view(letters).substr(0, 2));
}

/// PDB's columns say that two letters are the symbol. Hydrogen is often out of its column: only
/// "HG" itself is mercury.
std::uint8_t column_pair(std::string_view name, const std::string& letters) {
  return letters[0] == 'H' && name.size() > 2 ? 0 : pair_of(letters);
}

/// PDB before 1992: in dinucleotides A or N before the symbol names the half ("AC2", "NO1", "NP").
std::uint8_t in_half(std::string_view residue, const std::string& letters) {
  constexpr std::array<std::string_view, 6> dinucleotides{"NAD", "NAP", "NDP", "NAH", "FAD", "COA"};
  constexpr std::string_view symbols = "HCNOP";
  if (letters.size() != 2 || symbols.find(letters[1]) == std::string_view::npos) return 0;
  const bool half =
      letters[0] == 'A' ||
      (letters[0] == 'N' && std::ranges::find(dinucleotides, residue) != dinucleotides.end());
  return half ? organic(letters[1]) : 0;
}

std::uint8_t in_ligand(std::string_view name, const std::string& letters) {
  if (is_bead(letters, name)) return 0;
  const std::string first = letters.substr(0, 2);
  if (first == "CL" || first == "BR") return pair_of(letters);
  if (letters.size() == 2 && is_plain_pair(letters)) return pair_of(letters);
  if (const std::uint8_t element = organic(letters[0])) return element;
  if (letters.size() == 1) return atomic_number_of(letters);
  return is_plain_pair(first) ? pair_of(letters) : 0;
}

/// Labels of sites: "Ca1", "CA1", "O1W".
std::uint8_t in_crystal(std::string_view name, const std::string& letters) {
  constexpr std::uint8_t uranium = 92;  // what comes after is a carbon or nitrogen: "CN1", "NO1"
  const bool lower = name.size() > 1 && ascii::is_lower(name[1]);
  const std::uint8_t pair = pair_of(letters);
  const bool exact = letters.size() == 2 && letters[0] != 'H' && pair <= uranium;
  if (pair != 0 && (lower || exact)) return pair;
  return atomic_number_of(std::string_view(letters).substr(0, 1));
}

bool is_polymer_or_water(std::string_view residue) {
  return is_water(residue) || is_amino_acid(residue) || is_nucleotide(residue);
}

/// A residue of one particle that is called as it is, and is no ion: a bead.
bool is_lone_bead(const AtomName& atom) {
  return atom.residue == atom.name && organic(ascii::upper(atom.name[0])) == 0 &&
         atom.name.size() == 1;
}

}  // namespace

std::uint8_t guess_element(const AtomName& atom) {
  const std::string_view name = from_letter(atom.name);
  if (name.empty()) return 0;
  const std::string letters = letters_of(name);
  if (!atom.in_molecule) return in_crystal(name, letters);
  if (is_virtual_site(atom.residue, atom.name, 0)) return 0;
  if (is_ion(atom.residue, atom.name)) {
    if (const std::uint8_t element = ion_element(atom.name)) return element;
  }
  if (is_polymer_or_water(atom.residue)) return in_polymer(name, letters);
  const bool charged = name.ends_with('+') || name.ends_with('-');
  if (charged && ion_element(name) != 0) return ion_element(name);
  if (atom.residue == "CIO" || atom.residue == "CIM") return ion_element(atom.residue);
  if (is_lone_bead(atom)) return 0;
  if (const std::uint8_t element = in_half(atom.residue, letters)) return element;
  if (atom.two_letters) {
    if (const std::uint8_t element = column_pair(name, letters)) return element;
  }
  return in_ligand(name, letters);
}

bool shows_flush_left(std::string_view residue, std::string_view name) {
  constexpr std::string_view symbols = "HCNOSP";
  if (name.empty() || name.size() > 3 ||
      symbols.find(ascii::upper(name[0])) == std::string_view::npos) {
    return false;
  }
  const std::string letters = letters_of(name);
  if (letters.size() == 1) return true;
  return letters != "SE" && !is_ion(residue, name) && !is_virtual_site(residue, name, 0) &&
         is_polymer_or_water(residue);
}

}  // namespace parray::input
