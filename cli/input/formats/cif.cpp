#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/input/formats/bond_fields.h"
#include "cli/input/formats/cif_atoms.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/gemmi_seam.h"
#include "cli/input/formats/notes.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Recognises three kinds of CIF: macromolecules (PDBx, names with a dot), crystals (core
/// dictionary, names without a dot) and components. In all of them, the first line that is neither
/// blank nor a comment starts with "data_".
Confidence looks_like_cif(const FileStart& start) {
  for (const std::string_view line : start.lines()) {
    const std::string_view text = trimmed(line);
    if (text.empty() || text.starts_with('#')) continue;
    return certain_if(lower_case(text.substr(0, 5)) == "data_");
  }
  return Confidence::none;
}

/// One of the two atoms of a bond.
struct CifLinkEnd {
  std::string name;
  std::string chain;
  std::string label_chain;  ///< instead of an empty `chain`
  std::string residue_number;
  std::string label_number = "1";  ///< instead of an empty `residue_number`; 1 in components
  std::string insertion;
  std::string alternative;
  /// The bond ends at the image of the atom under this symmetry operation. "1_555" (in mmCIF): the
  /// atom itself.
  std::string symmetry;
};

constexpr std::string_view links_prefix = "_struct_conn_";
constexpr std::string_view types_prefix = "_struct_conn_type_";
constexpr std::string_view component_prefix = "_chem_comp_bond_";
constexpr std::string_view kind_tag = "_struct_conn_conn_type_id";

using Tag = std::pair<std::string_view, std::string CifLinkEnd::*>;

/// Tags of the dictionary mmcif_pdbx, with '#' for the number of the atom.
constexpr std::array<Tag, 10> end_tags{{
    {"_struct_conn_ptnr#_label_atom_id", &CifLinkEnd::name},
    {"_struct_conn_ptnr#_label_asym_id", &CifLinkEnd::label_chain},
    {"_struct_conn_ptnr#_label_seq_id", &CifLinkEnd::label_number},
    {"_struct_conn_ptnr#_label_alt_id", &CifLinkEnd::alternative},
    {"_struct_conn_ptnr#_auth_asym_id", &CifLinkEnd::chain},
    {"_struct_conn_ptnr#_auth_seq_id", &CifLinkEnd::residue_number},
    {"_struct_conn_pdbx_ptnr#_pdb_ins_code", &CifLinkEnd::insertion},
    {"_struct_conn_pdbx_ptnr#_label_alt_id", &CifLinkEnd::alternative},
    {"_struct_conn_ptnr#_symmetry", &CifLinkEnd::symmetry},
    {"_chem_comp_bond_atom_id_#", &CifLinkEnd::name},
}};

/// Finds particles by names. Looks for all of them in one pass.
class NamedParticles {
 public:
  explicit NamedParticles(const Particles& particles) : particles_(particles) {}

  void want(const CifLinkEnd& end) {
    if (const auto key = key_of(end)) found_[*key];
  }
  void search() {
    for (std::size_t i = 0; i < particles_.count(); ++i) {
      const auto known = found_.find(key_of(i));
      if (known != found_.end()) known->second.push_back(i);
    }
  }
  /// Returns the only particle that fits. Returns nothing if there is none or there are several.
  [[nodiscard]] std::optional<std::size_t> find(const CifLinkEnd& end) const {
    const auto key = key_of(end);
    if (!key) return {};
    std::optional<std::size_t> particle;
    for (const std::size_t i : found_.at(*key)) {
      if (!is_location(i, end.alternative)) continue;
      if (particle) return {};
      particle = i;
    }
    return particle;
  }

 private:
  using Key = std::tuple<std::size_t, std::size_t, std::int32_t, char>;

  static std::optional<std::size_t> number_of(const std::string& name, const NameColumn& column) {
    if (column.empty()) return 0;
    return place_in(column.names, name);
  }
  [[nodiscard]] std::optional<Key> key_of(const CifLinkEnd& end) const {
    const auto name = number_of(end.name, particles_.atom_names);
    const auto chain =
        number_of(end.chain.empty() ? end.label_chain : end.chain, particles_.chains);
    const auto residue =
        residue_number_in(end.residue_number.empty() ? end.label_number : end.residue_number);
    if (!name || !chain || !residue) return {};
    const bool codes = !particles_.insertion_codes.empty() && !end.insertion.empty();
    return Key(*name, *chain, particles_.residue_numbers.empty() ? 0 : *residue,
               codes ? end.insertion[0] : ' ');
  }
  [[nodiscard]] Key key_of(std::size_t i) const {
    const auto in = [i](const auto& column) { return column.empty() ? 0 : column[i]; };
    const char code = particles_.insertion_codes.empty() ? ' ' : particles_.insertion_codes[i];
    return Key(in(particles_.atom_names.index), in(particles_.chains.index),
               in(particles_.residue_numbers), code);
  }
  [[nodiscard]] bool is_location(std::size_t i, const std::string& letter) const {
    const std::vector<char>& letters = particles_.alternatives;
    return letters.empty() || letters[i] == ' ' || letter.empty() || letters[i] == letter[0];
  }

  const Particles& particles_;
  std::map<Key, std::vector<std::size_t>> found_;
};

/// The tables of bonds in a block: the bonds that CIF states between named atoms. struct_conn of
/// mmCIF has links between residues, chem_comp_bond of components has all bonds.
class CifLinks {
 public:
  /// Returns whether a plain tag (plain_tag() in cif_atoms.h) belongs to a table of bonds.
  static bool is_table(std::string_view plain_tag) {
    return plain_tag.starts_with(component_prefix) ||
           (plain_tag.starts_with(links_prefix) && !plain_tag.starts_with(types_prefix));
  }

  /// Begins a table with these plain tags, one or more.
  void start(const std::vector<std::string>& tags) {
    component_ = tags[0].starts_with(component_prefix);
    columns_.clear();
    next_ = 0;
    for (const std::string& tag : tags) {
      Column column;
      column.kind = tag == kind_tag;
      for (const auto& [pattern, member] : end_tags) {
        std::string wanted(pattern);
        for (std::size_t end = 0; end < 2; ++end) {
          wanted[pattern.find('#')] = end == 0 ? '1' : '2';
          if (tag == wanted) column = {member, end, false};
        }
      }
      columns_.push_back(column);
    }
  }

  /// Adds the next value of the table, without quotes.
  void add(std::string value) {
    if (next_ == 0) links_.emplace_back().component = component_;
    Link& link = links_.back();
    const Column& column = columns_[next_];
    if (column.kind) link.kind = lower_case(value);
    if (column.member != nullptr) link.ends.at(column.end).*column.member = std::move(value);
    next_ = next_ + 1 == columns_.size() ? 0 : next_ + 1;
  }

  /// Adds bonds to the particles. `component` true: those of chem_comp_bond. False: covalent,
  /// disulfide and metal bonds of struct_conn whose ends have the same symmetry operation. A note
  /// counts the bonds that were left out, because an atom is missing or occurs several times.
  void finish(bool component, Particles& particles) const {
    NamedParticles named(particles);
    std::vector<const Link*> bonds;
    for (const Link& link : links_) {
      if (link.component != component || !is_bond(link)) continue;
      bonds.push_back(&link);
      for (const CifLinkEnd& end : link.ends) named.want(end);
    }
    if (bonds.empty()) return;
    named.search();
    std::uint64_t unknown = 0;
    for (const Link* link : bonds) {
      const auto first = named.find(link->ends[0]);
      const auto second = named.find(link->ends[1]);
      if (first && second && *first != *second) {
        particles.bonds.push_back(bond_between(*first, *second));
      } else {
        ++unknown;
      }
    }
    put_in_order(particles.bonds);
    particles.all_bonds = component && !particles.bonds.empty();
    add_note(particles.facts.notes, unknown_bonds_note(unknown));
  }

 private:
  struct Column {
    std::string CifLinkEnd::*member = nullptr;
    std::size_t end = 0;
    bool kind = false;  ///< the kind of the bond
  };
  struct Link {
    std::array<CifLinkEnd, 2> ends;
    bool component = false;
    std::string kind;
  };

  static bool is_bond(const Link& link) {
    const bool known = link.component || link.kind.starts_with("covale") || link.kind == "disulf" ||
                       link.kind == "metalc";
    return known && link.ends[0].symmetry == link.ends[1].symmetry;
  }

  bool component_ = false;       // of the current table
  std::vector<Column> columns_;  // of the current table
  std::size_t next_ = 0;
  std::vector<Link> links_;
};

constexpr std::array<std::string_view, 2> operation_tags{"_space_group_symop_operation_xyz",
                                                         "_symmetry_equiv_pos_as_xyz"};

/// Returns true for the items outside loops that ParRay uses: those of the cell and its symmetry,
/// and those of a single atom or bond.
bool is_wanted(std::string_view tag) {
  return tag.starts_with("_cell_") || tag.starts_with("_symmetry_") ||
         tag.starts_with("_space_group_") || table_of(tag) != CifTable::other ||
         CifLinks::is_table(tag);
}

/// Goes through the blocks and reads the first one with atoms.
class CifReader : public CifVisitor {
 public:
  CifReader(const std::string& file, const ParticleRequest& request)
      : place_{file, FilePlace::Unit::line, 1}, sites_(request, place_) {}

  [[nodiscard]] const FilePlace& place() const { return place_; }
  void at_line(std::uint64_t line) { place_.number = line; }

  void start_block() override { end_block(); }

  void start_loop() override {
    in_loop_ = true;
    tags_.clear();
  }

  void tag(std::string_view text, std::size_t line) override {
    constexpr std::size_t max_tags = 1000;
    at_line(line);
    std::string name = plain_tag(text);
    if (!in_loop_) {
      item_ = is_wanted(name) ? std::move(name) : "";
      return;
    }
    if (tags_.size() == max_tags) {
      place_.fail("a loop has more than 1000 columns: remove columns and their values");
    }
    tags_.push_back(std::move(name));
  }

  void value(std::string_view text, std::size_t line) override {
    place_.number = line;
    if (!in_loop_) {
      if (!item_.empty()) items_[item_] = text;
      return;
    }
    if (!tags_.empty()) start_rows();
    const bool of_operation = kind_ == Kind::operations && column_ == operation_column_;
    if (kind_ == Kind::atoms && row_.add(text)) sites_.add(row_);
    if (kind_ == Kind::links) links_.add(cif_text(std::string(text)));
    if (of_operation) operations_.push_back(cif_text(std::string(text)));
    if (kind_ == Kind::geometry && column_ == 0) ++geometry_bonds_;
    column_ = column_ + 1 == columns_ ? 0 : column_ + 1;
  }

  void end_loop() override {
    if (!tags_.empty()) start_rows();  // a loop without rows
    if (kind_ == Kind::atoms && row_.begun() > 0) {
      place_.fail_incomplete("the last row of the atom table has " + std::to_string(row_.begun()) +
                             " of " + std::to_string(row_.width()) + " values");
    }
    kind_ = Kind::other;
    in_loop_ = false;
  }

  Particles finish() {
    end_block();
    if (!done_) {
      place_.fail(
          "the file has no atoms: add _atom_site or _chem_comp_atom with Cartesian or fractional "
          "coordinates");
    }
    Particles particles = sites_.finish(crystal_);
    chosen_links_.finish(sites_.is_component(), particles);
    add_note(particles.facts.notes,
             {"geometry_bonds", chosen_geometry_bonds_,
              in_number(chosen_geometry_bonds_, "bond", "bonds") +
                  " of the table _geom_bond not read: ParRay finds bonds by distances"});
    add_note(particles.facts.notes,
             {"blocks", more_blocks_,
              in_number(more_blocks_, "further block with atoms, which is not read",
                        "further blocks with atoms, which are not read")});
    return particles;
  }

 private:
  enum class Kind : std::uint8_t { other, atoms, operations, links, geometry };

  /// Chooses the kind of the loop at its first value, when all columns are known.
  void start_rows() {
    kind_ = Kind::other;
    const std::vector<std::string> tags = std::exchange(tags_, {});
    columns_ = tags.size();
    column_ = 0;
    if (start_atoms(tags)) return;
    if (CifLinks::is_table(tags[0]) && !done_) {
      links_.start(tags);
      kind_ = Kind::links;
      return;
    }
    if (tags[0].starts_with("_geom_bond_")) kind_ = Kind::geometry;
    for (const std::string_view tag : operation_tags) {
      const auto at = place_in(tags, tag);
      if (!at || done_ || !operations_.empty()) continue;
      kind_ = Kind::operations;
      operation_column_ = *at;
    }
  }

  /// Returns true for a table of atoms.
  bool start_atoms(const std::vector<std::string>& tags) {
    const CifTable table = table_of(tags[0]);
    if (table == CifTable::other) return false;
    row_.start(tags);
    const bool partly =
        row_.has(CifItem::x) || row_.has(CifItem::fract_x) || row_.has(CifItem::ideal_x);
    if (!partly) return true;  // kind_ stays other
    if (done_ || sites_.has_table()) {
      more_atoms_ = more_atoms_ || done_;
      return true;
    }
    check_axes();
    sites_.start(table, row_);
    kind_ = Kind::atoms;
    return true;
  }

  void check_axes() const {
    for (const CifItem first : {CifItem::x, CifItem::fract_x, CifItem::ideal_x}) {
      for (const int step : {1, 2}) {
        const CifItem axis = CifRow::after(first, step);
        if (!row_.has(first) || row_.has(axis)) continue;
        place_.fail(std::string("the table has a column ")
                        .append(CifRow::axis_name(first))
                        .append(", but no ")
                        .append(CifRow::axis_name(axis)) +
                    ": add it");
      }
    }
  }

  /// Reads the items of a single atom or bond as a table with one row.
  void read_items() {
    std::vector<std::string> of_atom;
    std::vector<std::string> of_link;
    for (const auto& [tag, value] : items_) {
      if (table_of(tag) != CifTable::other) of_atom.push_back(tag);
      if (CifLinks::is_table(tag)) of_link.push_back(tag);
    }
    if (!of_atom.empty() && start_atoms(of_atom) && kind_ == Kind::atoms) {
      for (const std::string& tag : of_atom) {
        if (row_.add(items_[tag])) sites_.add(row_);
      }
      kind_ = Kind::other;
    }
    if (!of_link.empty()) links_.start(of_link);
    for (const std::string& tag : of_link) links_.add(cif_text(items_[tag]));
  }

  void end_block() {
    read_items();
    more_blocks_ += std::exchange(more_atoms_, false) ? 1 : 0;
    if (!done_ && sites_.has_table()) {
      done_ = true;
      keep_cell();
      chosen_links_ = std::move(links_);
      chosen_geometry_bonds_ = geometry_bonds_;
    }
    links_ = {};
    geometry_bonds_ = 0;
    items_.clear();
    operations_.clear();
  }

  /// Returns the value of an item without quotes. Returns "" for a missing item, '.' and '?'.
  [[nodiscard]] std::string item(std::string_view tag) const {
    const auto found = items_.find(tag);
    return found == items_.end() ? "" : cif_text(found->second);
  }

  [[nodiscard]] double number_of(std::string_view tag, double otherwise) const {
    return number_in(without_uncertainty(item(tag))).value_or(otherwise);
  }

  void keep_cell() {
    crystal_.lengths = {number_of("_cell_length_a", 0), number_of("_cell_length_b", 0),
                        number_of("_cell_length_c", 0)};
    crystal_.angles = {number_of("_cell_angle_alpha", 90), number_of("_cell_angle_beta", 90),
                       number_of("_cell_angle_gamma", 90)};
    crystal_.operations = operations_;
    for (const std::string_view tag : operation_tags) {
      if (operations_.empty() && items_.contains(tag)) crystal_.operations = {item(tag)};
    }
    for (const char* tag :
         {"_symmetry_int_tables_number", "_space_group_it_number", "_symmetry_space_group_name_h-m",
          "_space_group_name_h-m_alt", "_symmetry_space_group_name_hall",
          "_space_group_name_hall"}) {  // ordered by precision: the last one given decides
      const std::string name = item(tag);
      const bool known = !name.empty() && !operations_of_space_group(name).empty();
      if (known) crystal_.space_group = name;
    }
  }

  FilePlace place_;
  CifSites sites_;
  CifRow row_;
  CifLinks links_;                           // of the current block
  CifLinks chosen_links_;                    // of the block with the atoms
  std::uint64_t geometry_bonds_ = 0;         // of the current block
  std::uint64_t chosen_geometry_bonds_ = 0;  // of the block with the atoms
  Crystal crystal_;
  std::map<std::string, std::string, std::less<>> items_;  // items of the current block
  std::vector<std::string> operations_;
  std::vector<std::string> tags_;  // tags of a loop whose rows have not begun
  std::string item_;               // tag of the next value; empty: ignore the value
  Kind kind_ = Kind::other;
  std::size_t column_ = 0;
  std::size_t columns_ = 0;
  std::size_t operation_column_ = 0;
  std::uint64_t more_blocks_ = 0;
  bool more_atoms_ = false;
  bool in_loop_ = false;
  bool done_ = false;
};

/// Reads CIF. Uses the first block with atoms:
/// - mmCIF (_atom_site with Cartesian coordinates): models are frames; reads the cell and bonds
///   between residues (_struct_conn). Numbers: occupancy, b_factor, charge (formal).
/// - CIF of crystals (_atom_site with fractional coordinates): see unit_cell(). Counts bonds
///   (_geom_bond) in a note. Numbers: occupancy, b_factor (computed from U if the file gives U).
/// - Components (_chem_comp_atom): ideal coordinates if all placed atoms have them, otherwise those
///   of the model. Reads bonds (_chem_comp_bond). Numbers: charge.
Particles read_cif(PackedFile& file, const ParticleRequest& request) {
  CifReader reader(file.name(), request);
  std::optional<bool> old_ends;  // whether lines end with "\r" alone, as on old Macintoshes
  const auto read = [&](char* to, std::size_t most) {
    const std::string_view text(to, file.read(to, most));
    const std::size_t end = old_ends ? std::string_view::npos : text.find_first_of("\r\n");
    if (end < text.size()) {
      old_ends = text[end] == '\r' && end + 1 < text.size() && text[end + 1] != '\n';
    }
    if (old_ends.value_or(false)) std::replace(to, to + text.size(), '\r', '\n');  // CIF needs "\n"
    return text.size();
  };
  try {
    parse_cif(read, reader);
  } catch (const CifError& error) {
    reader.at_line(std::max<std::uint64_t>(error.line(), reader.place().number));
    reader.place().fail("the file is not valid CIF (" + printable(error.what()) +
                        "): check that this is the right file");
  }
  return reader.finish();
}

}  // namespace

constinit const ParticleFormat cif_format{.name = "CIF",
                                          .extensions = {".cif", ".mmcif", ".pdbx"},
                                          .frames = true,
                                          .in_angstrom = true,
                                          .confidence = looks_like_cif,
                                          .read = read_cif};

}  // namespace parray::input
