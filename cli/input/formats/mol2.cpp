#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

Confidence looks_like_mol2(const FileStart& start) {
  return certain_if(std::ranges::any_of(
      start.lines(), [](std::string_view line) { return line.starts_with("@<TRIPOS>MOLECULE"); }));
}

/// Types of GAFF and GAFF2 (files gaff.dat and gaff2.dat of AmberTools).
constexpr std::array<TypesOfElement, 10> gaff_types{
    {{" h1 h2 h3 h4 h5 ha hc hn ho hp hs hw hx ", 1},
     {" c c1 c2 c3 c5 c6 ca cc cd ce cf cg ch cp cq cs cu cv cx cy cz ", 6},
     {" n n1 n2 n3 n4 n5 n6 n7 n8 n9 n+ na nb nc nd ne nf nh ni nj nk nl nm nn no np nq ns nt nu "
      "nv nx ny nz ",
      7},
     {" o oh op oq os ow ", 8},
     {" f ", 9},
     {" p2 p3 p4 p5 pb pc pd pe pf px py ", 15},
     {" s s2 s4 s6 sh sp sq ss sx sy ", 16},
     {" cl ", 17},
     {" br ", 35},
     {" i ", 53}}};

/// Returns the element of an atom type. SYBYL's types are a symbol ("Cl", "Fe"), often with a
/// suffix after a dot ("C.ar", "O.co2"); "Du", "LP", "Any", "Hal", "Het" and "Hev" are not
/// elements. GAFF's types are in lower case: "ca" is an aromatic carbon. Returns nothing for types
/// of other force fields (AMBER's "CA", "opls_135"); the atom's name must decide.
std::optional<std::uint8_t> element_of_type(std::string_view type) {
  const std::string_view symbol = type.substr(0, type.find('.'));
  constexpr std::array<std::string_view, 6> none{"Du", "LP", "Any", "Hal", "Het", "Hev"};
  if (place_in(none, symbol)) return 0;
  if (symbol.empty()) return {};
  if (ascii::is_lower(symbol[0])) return element_of_listed(gaff_types, type);
  const bool sybyl = symbol.size() == 1 || ascii::is_lower(symbol[1]);
  const std::uint8_t element = sybyl ? atomic_number_of(symbol) : 0;
  return element != 0 ? std::optional(element) : std::nullopt;
}

/// Splits the name of a substructure into the name and number of its residue: "ALA12". "<0>" means
/// none.
std::pair<std::string_view, std::optional<std::int32_t>> residue_in(std::string_view name) {
  if (name.starts_with('<')) return {};
  std::size_t end = name.size();
  while (end > 0 && ascii::is_digit(name[end - 1])) --end;
  if (end == 0 || end == name.size()) return {name, {}};
  return {name.substr(0, end), residue_number_in(name.substr(end))};
}

/// Reads the molecules one by one. Each begins with its @<TRIPOS>MOLECULE.
class Mol2Frames final : public FramesOf<ParticleInput> {
 public:
  Mol2Frames(PackedFile& file, const ParticleRequest& request) : FramesOf(file, request) {
    while (go_to_section() && section_ != "MOLECULE") {
    }
  }

  bool next() override { return section_ == "MOLECULE"; }

  std::uint64_t skip() override {
    std::uint64_t atoms = 0;
    while (go_to_section() && section_ != "MOLECULE") {
      while (next_row()) atoms += section_ == "ATOM" ? 1 : 0;
    }
    return atoms;
  }

  Particles read() override {
    AtomColumns atoms(input_.place(), request_, {"charge"});
    atoms.states_all_bonds();
    std::optional<ParticleCell> cell;
    while (go_to_section() && section_ != "MOLECULE") {
      while (next_row()) {
        if (section_ == "ATOM") add_atom(atoms);
        if (section_ == "CRYSIN") cell = cell_in_row();
        if (section_ == "BOND") add_bond(atoms);
      }
    }
    Particles particles = atoms.finish_frame();
    particles.cell = cell;
    return particles;
  }

 private:
  static constexpr std::string_view mark = "@<TRIPOS>";

  /// Goes to the heading of the next section. Returns false at the end of the file.
  bool go_to_section() {
    while (!at_heading_ && input_.next_line()) at_heading_ = input_.line().starts_with(mark);
    section_ = at_heading_ ? trimmed(input_.line().substr(mark.size())) : "";
    return std::exchange(at_heading_, false);
  }

  /// Splits the next line with words. Returns false at the end of the section.
  bool next_row() {
    while (input_.next_line()) {
      at_heading_ = input_.line().starts_with(mark);
      if (at_heading_) return false;
      split_at_blanks(input_.line(), words_);
      if (!words_.empty() && words_[0][0] != '#') return true;
    }
    return false;
  }

  void add_atom(AtomColumns& atoms) const {
    constexpr std::size_t least = 6;  // id name x y z type
    if (words_.size() < least) {
      input_.fail_incomplete("the line needs number, name, x, y, z and type of an atom");
    }
    Atom atom;
    atom.name = words_[1];
    atom.position = position_field(words_, 2, input_.place());
    atom.type = words_[5];
    atom.element = element_of_type(atom.type);
    if (words_.size() > 7) {
      const auto [name, number] = residue_in(words_[7]);
      atom.residue_name = name;
      atom.residue_number = number ? *number : residue_number_in(words_[6]).value_or(0);
    }
    atoms.add(atom);
    atoms.numbers({{words_.size() > 8 ? number_or_nan(words_[8]) : not_known}});
  }

  /// Adds the bond in a row: number, two atoms in the order of the file, type. "nc" means that the
  /// atoms are not connected.
  void add_bond(AtomColumns& atoms) const {
    if (words_.size() < 3) {
      input_.fail_incomplete("the line needs number, two atoms and type of a bond");
    }
    if (words_.size() > 3 && words_[3] == "nc") return;
    if (atoms.count() == 0) {
      input_.fail("section BOND precedes the atoms: move section ATOM before it");
    }
    atoms.bond(bond_field(words_[1], words_[2], atoms.count(), input_.place()));
  }

  [[nodiscard]] std::optional<ParticleCell> cell_in_row() const {
    std::array<double, 6> values{};
    if (words_.size() < values.size()) return {};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = number_in(words_[i]).value_or(0);
    const auto [a, b, c, alpha, beta, gamma] = values;
    return cell_from({a, b, c}, {alpha, beta, gamma});
  }

  std::string section_;
  bool at_heading_ = false;
  std::vector<std::string_view> words_;
};

}  // namespace

/// Reads MOL2 ("Tripos Mol2 File Format", 2009). Molecules are frames, CRYSIN is the cell. Numbers:
/// charge. Types are those of SYBYL or any other text.
constinit const ParticleFormat mol2_format =
    frames_in_angstrom<Mol2Frames>("MOL2", {".mol2"}, looks_like_mol2);

}  // namespace parray::input
