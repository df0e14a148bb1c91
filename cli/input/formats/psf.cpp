#include <limits>

#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/name_table.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

Confidence looks_like_psf(const FileStart& start) {
  const std::string_view first = start.line(0);
  return certain_if(first == "PSF" || first.starts_with("PSF "));
}

/// Parses the number at the beginning of a text such as "42A", a residue with its insertion code.
std::optional<std::int32_t> leading_number(std::string_view text) {
  const std::optional<double> number =
      number_in(text.substr(0, text.find_last_of("-0123456789") + 1));
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  if (!number || *number < -most || *number > most) return {};
  return static_cast<std::int32_t>(*number);
}

/// Reads a row: number, segment (which may be blank), residue number, residue name, name, type,
/// charge, mass. Ignores further columns.
void add_atom(const std::vector<std::string_view>& row, const FilePlace& place, NameTable& atoms) {
  constexpr std::size_t least_columns = 8;
  const bool has_segment = row.size() >= least_columns && leading_number(row[2]).has_value();
  const std::size_t at = has_segment ? 2 : 1;
  if (row.size() < at + 6) {
    place.fail_incomplete(std::to_string(row.size()) +
                          " columns, but an atom of PSF has at least 8, or 7 without a segment");
  }
  Atom atom;
  if (has_segment) atom.chain = row[1];
  atom.residue_number = leading_number(row[at]).value_or(0);
  if (ascii::is_letter(row[at].back())) atom.insertion = row[at].back();
  atom.residue_name = row[at + 1];
  atom.name = row[at + 2];
  atom.type = row[at + 3];
  const double charge = number_field(row[at + 4], "charge", place);
  atoms.add(atom, charge, number_field(row[at + 5], "mass", place));
}

/// Returns the count of the section NATOM. The next line is its first row.
std::uint64_t find_atoms(ParticleInput& input) {
  if (!input.next_line() || !input.line().starts_with("PSF")) {
    input.fail("this is not a PSF file: it does not begin with PSF");
  }
  while (input.next_line()) {
    const std::vector<std::string_view> words = words_of(input.line());
    if (words.size() >= 2 && words[1].starts_with("!NATOM")) {
      return count_field(words[0], input.place());
    }
  }
  input.fail_incomplete("the file has no section !NATOM");
}

/// Returns the count of the section NBOND, which follows the atoms. Returns 0 without the section.
std::uint64_t find_bonds(ParticleInput& input) {
  constexpr int most_lines = 10;
  for (int i = 0; i < most_lines && input.next_line(); ++i) {
    const std::vector<std::string_view> words = words_of(input.line());
    const bool found = words.size() >= 2 && words[1].starts_with("!NBOND");
    if (found) return natural_in(words[0]).value_or(0);
  }
  return 0;
}

/// Reads the pairs of atoms in the section NBOND, several in a line.
std::vector<StatedBond> bonds_in(ParticleInput& input, std::uint64_t atoms) {
  const std::uint64_t count = find_bonds(input);
  std::vector<StatedBond> bonds;
  std::vector<std::string_view> row;
  while (bonds.size() < count) {
    input.next_row(bonds.size(), count, "bonds");
    split_at_blanks(input.line(), row);
    for (std::size_t i = 0; i < row.size() && bonds.size() < count; i += 2) {
      const std::string_view other = i + 1 < row.size() ? row[i + 1] : "";
      bonds.push_back(bond_field(row[i], other, atoms, input.place()));
    }
  }
  put_in_order(bonds);
  return bonds;
}

/// Reads PSF of CHARMM, X-PLOR and NAMD: sections NATOM and NBOND. Elements come from the
/// masses. Format: "PSF files", NAMD tutorial, appendix; CHARMM documentation, "struct".
Particles read_psf(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  const std::uint64_t count = find_atoms(input);
  NameTable atoms(input.place());
  std::vector<std::string_view> row;
  for (std::uint64_t i = 0; i < count; ++i) {
    input.next_row(i, count, "atoms");
    split_at_blanks(input.line(), row);
    add_atom(row, input.place(), atoms);
  }
  Particles particles = atoms.finish(request);
  particles.bonds = bonds_in(input, count);
  particles.all_bonds = !particles.bonds.empty();
  return particles;
}

}  // namespace

constinit const ParticleFormat psf_format{.name = "PSF",
                                          .extensions = {".psf"},
                                          .confidence = looks_like_psf,
                                          .read = read_psf,
                                          .holds = ParticleFormat::Holds::names};

}  // namespace parray::input
