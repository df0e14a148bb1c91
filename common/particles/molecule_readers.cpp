// gemmi's headers are heavy: only this file includes them.
#include <algorithm>
#include <array>
#include <cmath>
#include <gemmi/cif.hpp>
#include <gemmi/elem.hpp>
#include <gemmi/numb.hpp>
#include <gemmi/pdb.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/base/printable.h"
#include "common/particles/particle_columns.h"
#include "common/particles/particle_text.h"
#include "common/particles/readers.h"

namespace parray {
namespace {

namespace pegtl = tao::pegtl;
namespace rules = gemmi::cif::rules;

/// An atom as both formats describe it.
struct Atom {
  Vec3d position;
  gemmi::Element element = gemmi::El::X;
  std::string residue;  ///< chain, number and insertion code
  std::string residue_name;
  std::string name;
  bool alternative = false;  ///< one of several locations
  double occupancy = 1;
};

/// Adds atoms, and of alternative locations only one: that of the highest occupancy, the first of
/// equals. Where even the residue is ambiguous, the first one met stays.
class AtomColumns {
 public:
  explicit AtomColumns(const FilePlace& place) : columns_(place) {}

  void add(const Atom& atom) {
    if (atom.alternative && !is_new(atom)) return;
    columns_.position(atom.position);
    columns_.element(static_cast<std::uint8_t>(atom.element.atomic_number()));
    columns_.type(atom.element.name());
  }

  Particles finish() { return columns_.finish(); }

 private:
  struct Kept {
    std::size_t index;
    double occupancy;
  };

  /// Whether no location of the atom is there; else the better one takes the place.
  bool is_new(const Atom& atom) {
    const std::string& residue_name =
        residue_names_.try_emplace(atom.residue, atom.residue_name).first->second;
    if (residue_name != atom.residue_name) return false;
    const auto [kept, fresh] =
        kept_.try_emplace(atom.residue + '\0' + atom.name, Kept{columns_.count(), atom.occupancy});
    if (fresh || atom.occupancy <= kept->second.occupancy) return fresh;
    columns_.move(kept->second.index, atom.position);
    kept->second.occupancy = atom.occupancy;
    return false;
  }

  ParticleColumns columns_;
  // Of atoms with alternative locations only.
  std::unordered_map<std::string, std::string> residue_names_;
  std::unordered_map<std::string, Kept> kept_;
};

// PDB

/// gemmi takes what is no number for 0, so the coordinates are read here: columns 31 to 54.
Vec3d pdb_position(std::string_view record, const FilePlace& place) {
  constexpr std::size_t start = 30;
  constexpr std::size_t width = 8;
  if (record.size() < start + 3 * width) {
    place.fail("the record ends before its coordinates, columns 31 to 54: is it complete?");
  }
  const auto field = [&](std::size_t i, std::string_view name) {
    return number_field(trimmed(record.substr(start + i * width, width)), name, place);
  };
  const double x = field(0, "x");
  const double y = field(1, "y");
  return {x, y, field(2, "z")};
}

/// One record at a time: gemmi's reader of files keeps the whole structure, and does not tell the
/// line of what is wrong.
gemmi::Structure parsed_by_gemmi(std::string_view record, const FilePlace& place) {
  constexpr std::size_t charge_column = 78;  // of no use here, and refused where it is odd
  try {
    return gemmi::read_pdb_string(std::string(record.substr(0, charge_column)) + "\n", "");
  } catch (const std::runtime_error&) {
    place.fail("not a record of an atom: is a column damaged?");
  }
}

Atom pdb_atom(std::string_view record, const FilePlace& place) {
  Atom atom;
  atom.position = pdb_position(record, place);
  const gemmi::Structure structure = parsed_by_gemmi(record, place);
  const gemmi::Chain& chain = structure.models.at(0).chains.at(0);
  const gemmi::Residue& residue = chain.residues.at(0);
  const gemmi::Atom& parsed = residue.atoms.at(0);
  atom.element = parsed.element;
  atom.residue = chain.name + '\0' + residue.seqid.str();
  atom.residue_name = residue.name;
  atom.name = parsed.name;
  atom.alternative = parsed.altloc != '\0';
  atom.occupancy = parsed.occ;
  return atom;
}

// mmCIF

/// The items of _atom_site that count, in lower case: CIF knows no letter case in names.
enum Item : std::size_t {
  x,
  y,
  z,
  symbol,
  auth_chain,
  label_chain,
  auth_number,
  label_number,
  insertion,
  auth_residue,
  label_residue,
  auth_name,
  label_name,
  alternative,
  occupancy,
  model,
  item_count
};
constexpr std::string_view category = "_atom_site.";
constexpr std::array<std::string_view, item_count> item_names{
    "cartn_x",           "cartn_y",       "cartn_z",       "type_symbol",
    "auth_asym_id",      "label_asym_id", "auth_seq_id",   "label_seq_id",
    "pdbx_pdb_ins_code", "auth_comp_id",  "label_comp_id", "auth_atom_id",
    "label_atom_id",     "label_alt_id",  "occupancy",     "pdbx_pdb_model_num"};

/// Collects the first _atom_site category, be it a loop or the items of a single atom.
class CifAtoms {
 public:
  explicit CifAtoms(const std::string& file)
      : place_{file, FilePlace::Unit::line, 1}, columns_(place_) {}

  [[nodiscard]] const FilePlace& place() const { return place_; }
  void at_line(std::size_t line) { place_.number = line; }

  void start_loop() {
    end_items();
    in_loop_ = true;
    first_tag_ = true;
  }

  void add_tag(std::string_view tag) {
    constexpr std::size_t max_tags = 1000;
    const std::string name = lower_case(tag);
    if (!in_loop_ || first_tag_) in_atoms_ = !done_ && name.starts_with(category);
    first_tag_ = false;
    if (!in_atoms_) {
      if (!in_loop_) end_items();
      return;
    }
    if (tags_.size() == max_tags) place_.fail("_atom_site has too many items: remove some");
    tags_.push_back(name);
  }

  void add_value(std::string_view value) {
    if (!in_atoms_) return;
    row_.emplace_back(value);
    if (in_loop_ && row_.size() == tags_.size()) add_row();
  }

  void end_loop() {
    if (!row_.empty()) {
      place_.fail("the last row of _atom_site has " + std::to_string(row_.size()) + " of " +
                  std::to_string(tags_.size()) + " values: is the file complete?");
    }
    end_category();
    in_loop_ = false;
  }

  /// What ends a run of items outside loops: anything else.
  void end_items() {
    if (in_loop_ || tags_.empty()) return;
    if (row_.size() != tags_.size()) place_.fail("an item of _atom_site has no value: add it");
    add_row();
    end_category();
  }

  Particles finish() {
    end_items();
    if (!done_) {
      place_.fail(
          "no atoms: mmCIF has them in _atom_site.Cartn_x, Cartn_y, Cartn_z; convert other "
          "kinds of CIF to XYZ");
    }
    return columns_.finish();
  }

 private:
  void end_category() {
    done_ = done_ || !tags_.empty();
    in_atoms_ = false;
    tags_.clear();
    row_.clear();
  }

  void find_items() {
    for (std::size_t i = 0; i < item_count; ++i) {
      const std::string name = std::string(category).append(item_names[i]);
      at_[i] =
          static_cast<std::size_t>(std::find(tags_.begin(), tags_.end(), name) - tags_.begin());
    }
    for (const Item axis : {x, y, z}) {
      if (has(axis)) continue;
      place_.fail("no _atom_site." + std::string(item_names[axis]) + ": add it");
    }
  }

  void add_row() {
    if (!done_) find_items();
    done_ = true;
    if (in_first_model()) columns_.add(atom());
    row_.clear();
  }

  bool in_first_model() {
    if (!has(model)) return true;
    if (!first_model_) first_model_ = row_[at_[model]];
    return row_[at_[model]] == *first_model_;
  }

  [[nodiscard]] Atom atom() const {
    Atom atom;
    atom.position = {number(x), number(y), number(z)};
    atom.element = gemmi::Element(text(symbol));
    atom.residue = text(auth_chain, label_chain) + '\0' + text(auth_number, label_number) + '\0' +
                   text(insertion);
    atom.residue_name = text(auth_residue, label_residue);
    atom.name = text(auth_name, label_name);
    atom.alternative = !text(alternative).empty();
    if (!text(occupancy).empty()) atom.occupancy = number(occupancy);
    return atom;
  }

  [[nodiscard]] bool has(Item item) const { return at_[item] < tags_.size(); }

  /// Without quotes; empty for what is missing, '.' or '?'.
  [[nodiscard]] std::string text(Item item) const {
    return has(item) ? gemmi::cif::as_string(row_[at_[item]]) : std::string();
  }
  [[nodiscard]] std::string text(Item item, Item other) const {
    std::string preferred = text(item);
    return preferred.empty() ? text(other) : preferred;
  }

  [[nodiscard]] double number(Item item) const {
    const std::string& value = row_[at_[item]];
    const double number = gemmi::cif::as_number(value);
    if (!std::isfinite(number)) {
      place_.fail(std::string(item_names[item]) + " '" + printable(value) +
                  "' is not a finite number: write it as 0.5 or 1e3");
    }
    return number;
  }

  FilePlace place_;
  AtomColumns columns_;
  std::vector<std::string> tags_;  // of the category, while in it
  std::vector<std::string> row_;
  std::array<std::size_t, item_count> at_{};  // columns; tags_.size(): missing
  std::optional<std::string> first_model_;
  bool in_loop_ = false;
  bool first_tag_ = false;
  bool in_atoms_ = false;
  bool done_ = false;  // atoms have been met
};

/// What gemmi's grammar of CIF meets, passed on. A rule without a Meet of its own means nothing.
template <typename Rule>
struct Meet : pegtl::nothing<Rule> {};

template <>
struct Meet<rules::datablockheading> {
  static void apply0(CifAtoms& atoms) { atoms.end_items(); }
};
template <>
struct Meet<rules::str_loop> {
  static void apply0(CifAtoms& atoms) { atoms.start_loop(); }
};
template <>
struct Meet<rules::loop> {
  static void apply0(CifAtoms& atoms) { atoms.end_loop(); }
};

struct MeetTag {
  template <typename Input>
  static void apply(const Input& in, CifAtoms& atoms) {
    atoms.at_line(in.iterator().line);
    atoms.add_tag(in.string_view());
  }
};
template <>
struct Meet<rules::item_tag> : MeetTag {};
template <>
struct Meet<rules::loop_tag> : MeetTag {};

struct MeetValue {
  template <typename Input>
  static void apply(const Input& in, CifAtoms& atoms) {
    atoms.at_line(in.iterator().line);
    atoms.add_value(in.string_view());
  }
};
template <>
struct Meet<rules::item_value> : MeetValue {};
template <>
struct Meet<rules::loop_value> : MeetValue {};

/// How the parser asks for bytes.
struct CifBytes {
  GzipFile* file;
  std::size_t operator()(char* to, std::size_t bytes) const { return file->read(to, bytes); }
};

constexpr std::size_t chunk_bytes = std::size_t{1} << 16;
using CifInput = pegtl::buffer_input<CifBytes, pegtl::eol::lf_crlf, std::string, chunk_bytes>;

}  // namespace

Particles read_pdb(ParticleInput& input) {
  AtomColumns atoms(input.place());
  while (input.next_line()) {
    const std::string_view line = input.line();
    if (line.starts_with("ATOM  ") || line.starts_with("HETATM")) {
      atoms.add(pdb_atom(line, input.place()));
    } else if (line.starts_with("ENDMDL") || trimmed(line) == "END") {
      break;
    }
  }
  return atoms.finish();
}

Particles read_mmcif(GzipFile& file) {
  constexpr std::size_t max_text_bytes = std::size_t{1} << 22;
  CifAtoms atoms(file.name());
  try {
    CifInput in(file.name(), max_text_bytes, CifBytes{&file});
    pegtl::parse<rules::file, Meet, gemmi::cif::Errors>(in, atoms);
  } catch (const pegtl::parse_error& error) {
    atoms.at_line(error.positions().front().line);
    atoms.place().fail("not CIF (" + std::string(error.message()) + "): is this the right file?");
  } catch (const std::overflow_error&) {  // the parser's buffer
    atoms.place().fail("a text or a comment after this is longer than " +
                       std::to_string(max_text_bytes) + " bytes: is this mmCIF?");
  }
  return atoms.finish();
}

}  // namespace parray
