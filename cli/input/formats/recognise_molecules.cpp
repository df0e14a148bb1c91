#include <algorithm>
#include <array>
#include <string>

#include "cli/input/formats/recognisers.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

using Words = std::vector<std::string_view>;

bool is_number_field(std::string_view text) { return number_in(trimmed(text)).has_value(); }

/// Columns `first` to `last`, counted from 1 as PDB's description does.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
  return line.size() < first ? std::string_view() : line.substr(first - 1, last - first + 1);
}

bool is_atom(std::string_view line) {
  return line.starts_with("ATOM ") || line.starts_with("ATOM\t") || line.starts_with("HETATM");
}

/// The first line of an atom; empty where there is none.
std::string_view first_atom(const FileStart& start) {
  const auto found = std::ranges::find_if(start.lines(), is_atom);
  return found == start.lines().end() ? std::string_view() : *found;
}

bool is_record_of_pdb(std::string_view line) {
  constexpr std::array<std::string_view, 39> names{
      "HEADER", "OBSLTE", "TITLE",  "SPLIT",  "CAVEAT", "COMPND", "SOURCE", "KEYWDS",
      "EXPDTA", "NUMMDL", "MDLTYP", "AUTHOR", "REVDAT", "SPRSDE", "JRNL",   "REMARK",
      "DBREF",  "DBREF1", "DBREF2", "SEQADV", "SEQRES", "MODRES", "HETNAM", "HETSYN",
      "FORMUL", "HELIX",  "SHEET",  "SSBOND", "LINK",   "CISPEP", "SITE",   "CRYST1",
      "ORIGX1", "ORIGX2", "ORIGX3", "SCALE1", "SCALE2", "SCALE3", "MODEL"};
  const std::string_view name = trimmed(columns(line, 1, 6));
  return std::ranges::find(names, name) != names.end();
}

bool has_two_decimals(std::string_view number) {
  return number.size() > 3 && number[number.size() - 3] == '.' && is_number_field(number);
}

/// "  1.00 20.00", as PDB writes an occupancy and a temperature factor; or nothing.
bool is_occupancy_and_factor(std::string_view tail) {
  const std::string_view occupancy = trimmed(columns(tail, 1, 6));
  const std::string_view factor = trimmed(columns(tail, 7, 12));
  return (occupancy.empty() || has_two_decimals(occupancy)) &&
         (factor.empty() || has_two_decimals(factor));
}

bool has_position_of_pdb(std::string_view atom) {
  return is_number_field(columns(atom, 31, 38)) && is_number_field(columns(atom, 39, 46)) &&
         is_number_field(columns(atom, 47, 54));
}

/// The first line of a CIF that says something: "data_...".
bool is_cif(const FileStart& start) {
  for (const std::string_view line : start.lines()) {
    const std::string_view text = trimmed(line);
    if (text.empty() || text.starts_with('#')) continue;
    return lower_case(text.substr(0, 5)) == "data_";
  }
  return false;
}

/// Whether the first name in a CIF has a dot.
bool has_dotted_names(const FileStart& start) {
  for (const std::string_view line : start.lines()) {
    const std::string_view text = trimmed(line);
    if (!text.starts_with('_')) continue;
    return text.substr(0, text.find_first_of(" \t")).find('.') != std::string_view::npos;
  }
  return false;
}

bool any_line_is(const FileStart& start, std::string_view text) {
  return std::ranges::any_of(start.lines(),
                             [&](std::string_view line) { return trimmed(line) == text; });
}

bool any_line_starts(const FileStart& start, std::string_view text) {
  return std::ranges::any_of(start.lines(),
                             [&](std::string_view line) { return line.starts_with(text); });
}

}  // namespace

Likeness looks_like_pdb(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  if (atom.empty()) {
    const auto records = std::ranges::count_if(start.lines(), is_record_of_pdb);
    if (!is_record_of_pdb(start.line(0))) return Likeness::none;
    if (trimmed(start.line(0)) == "TITLE") return Likeness::none;  // GROMOS96: PDB's has a text
    const bool most = records >= 3 && 2 * records > std::ssize(start.lines());
    return most ? Likeness::likely : Likeness::possible;
  }
  if (!has_position_of_pdb(atom) || looks_like_pdbqt(start) == Likeness::certain ||
      !is_occupancy_and_factor(columns(atom, 55, 66))) {
    return Likeness::possible;
  }
  return Likeness::likely;
}

Likeness looks_like_pdbqt(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  if (atom.empty() || !has_position_of_pdb(atom)) return Likeness::none;
  if (any_line_is(start, "ROOT") || any_line_is(start, "ENDROOT")) return Likeness::certain;
  const std::string_view charge = trimmed(columns(atom, 69, 76));
  const bool has_charge = is_number_field(charge) && charge.find('.') != std::string_view::npos;
  return certain_if(has_charge && !trimmed(columns(atom, 78, 79)).empty());
}

Likeness looks_like_pqr(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  Words words;
  split_at_blanks(atom, words);
  constexpr std::size_t least = 9;  // without chain and residue's name
  constexpr std::size_t most = 11;
  constexpr std::size_t numbers = 5;  // position, charge, radius
  if (words.size() < least || words.size() > most ||
      !std::all_of(words.end() - numbers, words.end(), is_number_field)) {
    return Likeness::none;
  }
  const bool as_pdb = has_position_of_pdb(atom) && is_occupancy_and_factor(columns(atom, 55, 66));
  const bool as_occupancy = has_two_decimals(words[words.size() - 2]);
  return as_pdb || as_occupancy ? Likeness::possible : Likeness::likely;
}

Likeness looks_like_mmcif(const FileStart& start) {
  if (!is_cif(start)) return Likeness::none;
  return has_dotted_names(start) ? Likeness::certain : Likeness::possible;
}

Likeness looks_like_cif(const FileStart& start) {
  if (!is_cif(start)) return Likeness::none;
  return has_dotted_names(start) ? Likeness::possible : Likeness::certain;
}

Likeness looks_like_sdf(const FileStart& start) {
  const std::string_view counts = trimmed(start.line(3));
  return certain_if(counts.ends_with("V2000") || counts.ends_with("V3000") ||
                    any_line_is(start, "M  END"));
}

Likeness looks_like_mol2(const FileStart& start) {
  return certain_if(any_line_starts(start, "@<TRIPOS>MOLECULE"));
}

Likeness looks_like_psf(const FileStart& start) {
  const std::string_view first = start.line(0);
  return certain_if(first == "PSF" || first.starts_with("PSF "));
}

Likeness looks_like_prmtop(const FileStart& start) {
  return certain_if(start.has("%VERSION") || start.has("%FLAG"));
}

}  // namespace parray::input
