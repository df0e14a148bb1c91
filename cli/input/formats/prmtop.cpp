#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/name_table.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

Confidence looks_like_prmtop(const FileStart& start) {
  return certain_if(start.has("%VERSION") || start.has("%FLAG"));
}

constexpr auto wanted_flags = std::to_array<std::string_view>(
    {"POINTERS", "ATOM_NAME", "CHARGE", "MASS", "ATOMIC_NUMBER", "RESIDUE_LABEL", "RESIDUE_POINTER",
     "AMBER_ATOM_TYPE", "BONDS_INC_HYDROGEN", "BONDS_WITHOUT_HYDROGEN"});

struct Section {
  using Fields = std::vector<std::string>;

  FilePlace place;  ///< its %FLAG
  Fields fields{};
};

/// The sections of the file: %FLAG NAME, %FORMAT(20a4), then lines of fields of equal width.
class Sections {
 public:
  explicit Sections(ParticleInput& input) : input_(input) {
    Section* section = nullptr;
    while (input.next_line()) {
      const std::string_view line = input.line();
      if (line.starts_with("%FLAG")) {
        const std::string name(trimmed(line.substr(5)));
        section = place_in(wanted_flags, name)
                      ? &sections_.try_emplace(name, Section{input.place()}).first->second
                      : nullptr;
        width_ = 0;
      } else if (section != nullptr && line.starts_with("%FORMAT")) {
        width_ = width_in(line);
      } else if (section != nullptr && !line.starts_with('%')) {
        split(line, section->fields);
      }
    }
  }

  /// Returns a section; one without fields if the file lacks it. Fails if the number of fields is
  /// not `count`.
  [[nodiscard]] const Section& of(const std::string& name, std::uint64_t count) const {
    static const Section none{};
    const auto found = sections_.find(name);
    if (found == sections_.end()) return none;
    const auto& [place, fields] = found->second;
    if (fields.size() == count) return found->second;
    place.fail_incomplete("section " + name + " has " + std::to_string(fields.size()) +
                          in_number(fields.size(), " field", " fields") + " instead of " +
                          std::to_string(count));
  }

  /// Returns the number at a place of the section POINTERS.
  [[nodiscard]] std::uint64_t pointer(std::size_t place) const {
    const auto found = sections_.find("POINTERS");
    if (found == sections_.end() || found->second.fields.size() <= place) {
      input_.fail(
          "the file has no complete section POINTERS: check that this is a PRMTOP file of AMBER 7 "
          "or later");
    }
    return count_field(found->second.fields[place], found->second.place);
  }

 private:
  /// Returns the width of a field: 4 for "%FORMAT(20a4)", 16 for "%FORMAT(5E16.8)".
  std::size_t width_in(std::string_view line) const {
    constexpr std::uint64_t most = 1000;
    const std::size_t letter = line.find_first_of("aAiIeEfF", line.find('('));
    const std::string_view rest = letter < line.size() ? line.substr(letter + 1) : "";
    const auto width = natural_in(rest.substr(0, rest.find_first_of(".)")));
    if (!width || *width == 0 || *width > most) {
      input_.fail("'" + printable(line) +
                  "' is not a valid format: write one such as %FORMAT(20a4)");
    }
    return static_cast<std::size_t>(*width);
  }

  void split(std::string_view line, Section::Fields& fields) const {
    if (width_ == 0) input_.fail_incomplete("fields precede their %FORMAT");
    while (!line.empty()) {
      const std::string_view field = line.substr(0, width_);
      if (line.size() < width_ && trimmed(field).empty()) return;
      fields.emplace_back(trimmed(field));
      line.remove_prefix(field.size());
    }
  }

  ParticleInput& input_;
  std::map<std::string, Section, std::less<>> sections_;
  std::size_t width_ = 0;
};

/// The residues of atoms. The file gives the number (from 1) of the first atom of each residue.
class Residues {
 public:
  Residues(const Sections& sections, std::uint64_t count, std::uint64_t atoms)
      : labels_(sections.of("RESIDUE_LABEL", count).fields) {
    const auto& [place, fields] = sections.of("RESIDUE_POINTER", count);
    for (const std::string& field : fields) {
      const std::uint64_t first = natural_in(field).value_or(0);
      if (first > atoms || first <= (firsts_.empty() ? 0 : firsts_.back())) {
        place.fail("RESIDUE_POINTER has '" + printable(field) +
                   "': write the number of the first atom of each residue, ascending from 1 to " +
                   std::to_string(atoms));
      }
      firsts_.push_back(first);
    }
    if (firsts_.size() != labels_.size()) firsts_.clear();
  }

  /// Sets the residue of an atom. Call it for the atoms in their order.
  void enter(std::uint64_t atom, Atom& to) {
    while (next_ < firsts_.size() && firsts_[next_] <= atom + 1) ++next_;
    if (next_ == 0) return;
    to.residue_name = labels_[next_ - 1];
    to.residue_number = static_cast<std::int32_t>(next_);
  }

 private:
  const Section::Fields& labels_;
  std::vector<std::uint64_t> firsts_;
  std::size_t next_ = 0;
};

double number_at(const Section::Fields& fields, std::size_t i) {
  return i < fields.size() ? number_or_nan(fields[i]) : not_known;
}

/// Parses atomic numbers. Negative numbers are virtual sites: 0.
std::vector<std::uint8_t> elements_in(const Section::Fields& numbers) {
  std::vector<std::uint8_t> elements(numbers.size());
  std::ranges::transform(numbers, elements.begin(), [](const std::string& text) {
    const std::uint64_t number = natural_in(text).value_or(0);
    return number <= last_element ? static_cast<std::uint8_t>(number) : std::uint8_t{0};
  });
  return elements;
}

/// Adds the bonds of a section: three times the place of each atom, then a type.
void add_bonds(const Section& section, std::uint64_t atoms, std::vector<StatedBond>& bonds) {
  const auto& [place, fields] = section;
  constexpr std::uint64_t step = 3;
  const auto number = [&place = place](const std::string& field) {
    const std::uint64_t offset = natural_in(field).value_or(1);
    if (offset % step == 0) return std::to_string(offset / step + 1);
    place.fail_incomplete("a bond has the offset '" + printable(field) +
                          "', which is not a multiple of 3");
  };
  for (std::size_t i = 0; i + 1 < fields.size(); i += step) {
    bonds.push_back(bond_field(number(fields[i]), number(fields[i + 1]), atoms, place));
  }
}

/// Reads PRMTOP of AMBER: names, residues, charges, bonds, and elements by atomic number or mass.
/// Format: "AMBER file formats", ambermd.org/FileFormats.php.
Particles read_prmtop(PackedFile& file, const ParticleRequest& request) {
  // places in POINTERS
  constexpr std::size_t bonds_with_hydrogen = 2;
  constexpr std::size_t other_bonds = 3;
  constexpr std::size_t residues_place = 11;
  constexpr double charge_unit = 18.2223;  // units of the file per elementary charge
  ParticleInput input(file);
  const Sections sections(input);
  const std::uint64_t count = sections.pointer(0);
  const auto& names = sections.of("ATOM_NAME", count).fields;
  const auto& types = sections.of("AMBER_ATOM_TYPE", count).fields;
  const auto& charges = sections.of("CHARGE", count).fields;
  const auto& masses = sections.of("MASS", count).fields;
  if (names.empty()) input.fail_incomplete("the file has no section ATOM_NAME");
  Residues residues(sections, sections.pointer(residues_place), count);
  NameTable atoms(input.place());
  for (std::size_t i = 0; i < names.size(); ++i) {
    Atom atom;
    atom.name = names[i];
    if (!types.empty()) atom.type = types[i];
    residues.enter(i, atom);
    atoms.add(atom, number_at(charges, i) / charge_unit, number_at(masses, i));
  }
  Particles particles =
      atoms.finish(request, elements_in(sections.of("ATOMIC_NUMBER", count).fields));
  for (const auto& [name, pointer] : {std::pair{"BONDS_INC_HYDROGEN", bonds_with_hydrogen},
                                      {"BONDS_WITHOUT_HYDROGEN", other_bonds}}) {
    add_bonds(sections.of(name, 3 * sections.pointer(pointer)), count, particles.bonds);
  }
  put_in_order(particles.bonds);
  particles.all_bonds = !particles.bonds.empty();
  return particles;
}

}  // namespace

constinit const ParticleFormat prmtop_format{.name = "PRMTOP",
                                             .extensions = {".prmtop", ".parm7", ".top"},
                                             .confidence = looks_like_prmtop,
                                             .read = read_prmtop,
                                             .holds = ParticleFormat::Holds::names};

}  // namespace parray::input
