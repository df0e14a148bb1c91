#pragma once

#include <string>
#include <string_view>

/// Units of length in the headers of files and on scale bars.
namespace parray::input {

/// A known unit of length.
struct LengthUnit {
  std::string_view name;  ///< as `--unit` takes it: "mm", "um", "angstrom", "kpc"
  double metres = 0;      ///< one unit in metres; 0: the name has several meanings ("au")
};

/// Returns the unit with this name, sign or common abbreviation, in any letter case: "MM",
/// "micron", "\u00b5m", "parsec". "A" is angstrom; "a" is no unit. Returns nullptr for other texts.
const LengthUnit* length_unit(std::string_view text);

/// Returns `text` as a unit that a label can show. Units of length get their names (LengthUnit).
/// Other units stay unchanged. Returns "" for texts that no label can show: longer than
/// longest_unit bytes, not UTF-8, or with control or invisible characters. Also knows the signs of
/// micrometres and angstrom in Latin-1.
std::string readable_unit(std::string_view text);

/// Returns the unit of length of a style of LAMMPS's command `units`: "angstrom" for "metal".
/// Returns "" for "lj" and unknown styles.
std::string_view length_unit_of_lammps(std::string_view style);

/// A length and its unit.
struct ShownLength {
  double value = 0;
  std::string unit;
};

/// Returns a length, > 0, in a unit that needs few digits: 0.05 m is 50 mm, 2000 pc is 2 kpc. Keeps
/// the unit for values in [0.1, 1000), for angstrom, and for units without prefixes.
ShownLength shown_length(double length, std::string_view unit);

}  // namespace parray::input
