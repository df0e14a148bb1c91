#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/base/printable.h"
#include "common/input/formats/atom_columns.h"
#include "common/input/formats/gemmi_seam.h"
#include "common/input/formats/readers.h"
#include "common/input/particles/elements.h"
#include "common/input/particles/particle_text.h"

namespace parray {
namespace {

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
class CifAtoms : public CifVisitor {
 public:
  explicit CifAtoms(const std::string& file)
      : place_{file, FilePlace::Unit::line, 1}, columns_(place_) {}

  [[nodiscard]] const FilePlace& place() const { return place_; }
  void at_line(std::uint64_t line) { place_.number = line; }

  void start_block() override { end_items(); }

  void start_loop() override {
    end_items();
    in_loop_ = true;
    first_tag_ = true;
  }

  void tag(std::string_view text, std::size_t line) override {
    constexpr std::size_t max_tags = 1000;
    at_line(line);
    const std::string name = lower_case(text);
    if (!in_loop_ || first_tag_) in_atoms_ = !done_ && name.starts_with(category);
    first_tag_ = false;
    if (!in_atoms_) {
      if (!in_loop_) end_items();
      return;
    }
    if (tags_.size() == max_tags) place_.fail("_atom_site has too many items: remove some");
    tags_.push_back(name);
  }

  void value(std::string_view text, std::size_t line) override {
    at_line(line);
    if (!in_atoms_) return;
    row_.emplace_back(text);
    if (in_loop_ && row_.size() == tags_.size()) add_row();
  }

  void end_loop() override {
    if (!row_.empty()) {
      place_.fail("the last row of _atom_site has " + std::to_string(row_.size()) + " of " +
                  std::to_string(tags_.size()) + " values: is the file complete?");
    }
    end_category();
    in_loop_ = false;
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
  /// What ends a run of items outside loops: anything else.
  void end_items() {
    if (in_loop_ || tags_.empty()) return;
    if (row_.size() != tags_.size()) place_.fail("an item of _atom_site has no value: add it");
    add_row();
    end_category();
  }

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
    atom.atomic_number = atomic_number_of(text(symbol));
    atom.residue = text(auth_chain, label_chain) + '\0' + text(auth_number, label_number) + '\0' +
                   text(insertion);
    atom.residue_name = text(auth_residue, label_residue);
    atom.name = text(auth_name, label_name);
    atom.alternative_location = !text(alternative).empty();
    if (!text(occupancy).empty()) atom.occupancy = number(occupancy);
    return atom;
  }

  [[nodiscard]] bool has(Item item) const { return at_[item] < tags_.size(); }

  /// Without quotes; empty for what is missing, '.' or '?'.
  [[nodiscard]] std::string text(Item item) const {
    return has(item) ? cif_text(row_[at_[item]]) : std::string();
  }
  [[nodiscard]] std::string text(Item item, Item other) const {
    std::string preferred = text(item);
    return preferred.empty() ? text(other) : preferred;
  }

  /// A standard uncertainty in brackets may follow: 1.234(5).
  [[nodiscard]] double number(Item item) const {
    const std::string_view value = row_[at_[item]];
    return number_field(value.substr(0, value.find('(')), item_names[item], place_);
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

}  // namespace

Particles read_mmcif(PackedFile& file, const ParticleRequest& /*request*/) {
  CifAtoms atoms(file.name());
  try {
    parse_cif([&file](char* to, std::size_t bytes) { return file.read(to, bytes); }, atoms);
  } catch (const CifError& error) {
    atoms.at_line(std::max<std::uint64_t>(error.line(), atoms.place().number));
    atoms.place().fail("not CIF (" + printable(error.what()) + "): is this the right file?");
  }
  return atoms.finish();
}

}  // namespace parray
