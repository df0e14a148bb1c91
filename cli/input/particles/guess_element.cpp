#include "cli/input/particles/guess_element.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/residues.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

constexpr std::uint8_t selenium = 34;

/// Returns the name from its first letter on: without blanks, marks and the leading digit of
/// "1HB2".
std::string_view from_letter(std::string_view name) {
  while (!name.empty() && !ascii::is_letter(name.front())) name.remove_prefix(1);
  return name;
}

/// Returns the letters at the start of a name, in upper case.
std::string letters_of(std::string_view name) {
  std::string letters;
  for (const char c : name) {
    if (!ascii::is_letter(c)) break;
    letters.push_back(ascii::upper(c));
  }
  return letters;
}

/// Returns the element of a letter in organic molecules, including deuterium. Returns 0 for other
/// letters.
std::uint8_t organic(char letter) {
  constexpr std::string_view symbols = "HDCNOSPFBI";
  return symbols.find(letter) == std::string_view::npos ? 0 : atomic_number_of({&letter, 1});
}

/// Returns true for two-letter symbols that are not the start of a usual atom name of C, H, N, O, P
/// or S.
bool is_plain_pair(std::string_view letters) {
  constexpr std::array<std::string_view, 42> pairs{
      "CL", "BR", "LI", "BE", "AL", "SI", "AR", "TI", "MN", "MG", "FE", "NI", "CU", "ZN",
      "GA", "GE", "AS", "SE", "KR", "ZR", "MO", "RU", "RH", "AG", "TE", "XE", "PT", "AU",
      "IR", "RB", "TL", "GD", "LA", "EU", "YB", "LU", "TB", "BI", "BA", "RE", "TA", "IN"};
  return std::ranges::find(pairs, letters) != pairs.end();
}

/// Returns true for "BB" and "SC1" to "SC6", the backbone and side chain beads of coarse models.
bool is_bead(std::string_view letters, std::string_view name) {
  return letters == "BB" || (letters == "SC" && name.size() == 3);
}

/// Returns the element in residues with known atoms: H, C, N, O, P, S, or selenium instead of
/// sulphur.
std::uint8_t in_polymer(std::string_view name, const std::string& letters) {
  if (is_bead(letters, name)) return 0;
  if (letters.starts_with("SE")) return selenium;
  constexpr std::string_view symbols = "HDCNOSP";
  return symbols.find(letters[0]) == std::string_view::npos ? 0 : organic(letters[0]);
}

std::uint8_t pair_of(const std::string& letters) {
  return letters.size() < 2 ? 0 : atomic_number_of(std::string_view(letters).substr(0, 2));
}

/// Returns the element when the columns of PDB indicate a two-letter symbol. Hydrogen is often out
/// of its column, so only "HG" itself is mercury.
std::uint8_t column_pair(std::string_view name, const std::string& letters) {
  return letters[0] == 'H' && name.size() > 2 ? 0 : pair_of(letters);
}

/// Handles PDB files before 1992: in dinucleotides, an A or N before the symbol names the half
/// ("AC2", "NO1", "NP").
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

/// Returns the element of a site label in a crystal: "Ca1", "CA1", "O1W".
std::uint8_t in_crystal(std::string_view name, const std::string& letters) {
  constexpr std::uint8_t uranium =
      92;  // symbols of later elements are labels of carbon or nitrogen: "CN1", "NO1"
  const bool lower = name.size() > 1 && ascii::is_lower(name[1]);
  const std::uint8_t pair = pair_of(letters);
  const bool exact = letters.size() == 2 && letters[0] != 'H' && pair <= uranium;
  if (pair != 0 && (lower || exact)) return pair;
  return atomic_number_of(std::string_view(letters).substr(0, 1));
}

/// Returns true for residues whose atoms have known names. UNK can be anything.
bool is_polymer_or_water(std::string_view residue) {
  if (residue == "UNK") return false;
  return is_water(residue) || is_amino_acid(residue) || is_nucleotide(residue);
}

/// Returns true for a bead: a one-particle residue with the name of its particle, which is not an
/// ion.
bool is_lone_bead(const AtomName& atom) {
  return atom.residue == atom.name && organic(ascii::upper(atom.name[0])) == 0 &&
         atom.name.size() == 1;
}

/// Standard atomic weights by atomic number, up to uranium. 0: no standard weight.
constexpr std::array<double, 93> weights{
    0,      1.008,  4.0026, 6.94,   9.0122, 10.81,  12.011, 14.007, 15.999, 18.998, 20.180, 22.990,
    24.305, 26.982, 28.085, 30.974, 32.06,  35.45,  39.95,  39.098, 40.078, 44.956, 47.867, 50.942,
    51.996, 54.938, 55.845, 58.933, 58.693, 63.546, 65.38,  69.723, 72.630, 74.922, 78.971, 79.904,
    83.798, 85.468, 87.62,  88.906, 91.224, 92.906, 95.95,  0,      101.07, 102.91, 106.42, 107.87,
    112.41, 114.82, 118.71, 121.76, 127.60, 126.90, 131.29, 132.91, 137.33, 138.91, 140.12, 140.91,
    144.24, 0,      150.36, 151.96, 157.25, 158.93, 162.50, 164.93, 167.26, 168.93, 173.05, 174.97,
    178.49, 180.95, 183.84, 186.21, 190.23, 192.22, 195.08, 196.97, 200.59, 204.38, 207.2,  208.98,
    0,      0,      0,      0,      0,      0,      232.04, 231.04, 238.03};

/// Smaller for light masses, because united atoms are close: CH2 weighs 14.027, N 14.007.
double tolerance_at(double mass) { return mass < 20 ? 0.015 : 0.03; }

std::uint8_t element_of_mass(double mass) {
  constexpr double deuterium = 2.014;
  if (std::abs(mass - deuterium) <= tolerance_at(mass)) return 1;
  const auto* const nearest = std::ranges::min_element(weights, {}, [mass](double weight) {
    return weight > 0 ? std::abs(weight - mass) : HUGE_VAL;
  });
  const bool near = std::abs(*nearest - mass) <= tolerance_at(mass);  // false for NaN
  return near ? static_cast<std::uint8_t>(nearest - weights.begin()) : 0;
}

}  // namespace

std::uint8_t element_of_columns(const AtomName& atom) {
  const bool symbol = atom.two_letters && atom.name.size() > 1 && ascii::is_upper(atom.name[0]) &&
                      ascii::is_lower(atom.name[1]) && !is_polymer_or_water(atom.residue);
  return symbol ? atomic_number_of(atom.name.substr(0, 2)) : 0;
}

std::uint8_t guess_element(const AtomName& atom) {
  if (const std::uint8_t element = element_of_columns(atom)) return element;
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

std::vector<std::uint8_t> elements_of_masses(const std::vector<double>& masses) {
  constexpr std::uint8_t helium = 2;
  std::vector<std::uint8_t> elements(masses.size());
  std::ranges::transform(masses, elements.begin(), element_of_mass);
  const bool chemistry = std::ranges::any_of(elements, [](auto e) { return e > helium; });
  if (!chemistry) std::ranges::fill(elements, std::uint8_t{0});
  return elements;
}

ParticleNote guessed_elements_note(std::uint64_t count, const std::string& how) {
  return {"guessed_elements", count, in_number(count, "element ", "elements ") + how};
}

ParticleNote unknown_elements_note(std::uint64_t count) {
  return {"unknown_elements", count,
          in_number(count, "particle", "particles") + " of an unknown element"};
}

void take_elements_of_masses(const std::vector<double>& masses, Particles& particles) {
  if (!particles.elements.empty() || particles.types.empty()) return;
  const std::vector<std::uint8_t> by_type = elements_of_masses(masses);
  std::vector<std::uint8_t> elements(particles.count());
  std::uint64_t guessed = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    elements[i] = by_type[particles.types.index[i]];
    guessed += elements[i] == 0 ? 0 : 1;
  }
  if (guessed == 0) return;
  const std::uint64_t unknown = particles.count() - guessed;
  particles.elements = std::move(elements);
  particles.facts.notes.push_back(guessed_elements_note(guessed, "guessed from masses"));
  if (unknown > 0) particles.facts.notes.push_back(unknown_elements_note(unknown));
}

}  // namespace parray::input
