#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/crystal.h"
#include "cli/input/particles/file_place.h"

namespace parray::input {

/// The columns of an atom table in CIF. Dictionaries use different names for some of them.
enum class CifItem : std::uint8_t {
  x,  // Cartesian, angstrom
  y,
  z,
  fract_x,  // fractions of the cell's edges
  fract_y,
  fract_z,
  ideal_x,  // of an isolated component, angstrom
  ideal_y,
  ideal_z,
  symbol,      // of the element
  auth_chain,  // auth: names that the authors chose; label: names of the database
  label_chain,
  auth_number,
  label_number,
  insertion,
  auth_residue,
  label_residue,
  auth_name,
  label_name,
  alternative,  // alternative location, or group of disorder
  assembly,     // of groups of disorder: see CrystalSite
  occupancy,
  b_factor,  // isotropic displacement, angstrom^2: B = 8 pi^2 U
  u_factor,
  charge,      // elementary charges
  calculated,  // "dum" marks a dummy site
  model,       // name of the model, usually a number
  count        // number of items; also means that a column is not used
};

/// The kinds of tables that contain atoms.
enum class CifTable : std::uint8_t {
  other,
  sites,      ///< atom_site: macromolecules or crystals
  components  ///< chem_comp_atom: one residue or ligand
};

/// Returns the tag in lower case with '_' instead of the dot of later dictionaries:
/// "_atom_site_cartn_x".
std::string plain_tag(std::string_view tag);

/// Returns the table to which a plain tag belongs.
CifTable table_of(std::string_view plain_tag);

/// A row of an atom table. It keeps only the columns that ParRay uses.
class CifRow {
 public:
  /// Begins a table with these plain tags.
  void start(const std::vector<std::string>& tags);

  /// Adds the next value of the row as in the file, with its quotes. Returns true for the last
  /// value of a row.
  bool add(std::string_view value) {
    const auto item = items_[next_];
    if (item != CifItem::count) texts_[static_cast<std::size_t>(item)].assign(value);
    next_ = next_ + 1 == items_.size() ? 0 : next_ + 1;
    return next_ == 0;
  }
  /// Returns the number of values of an incomplete row. 0: the last row is complete.
  [[nodiscard]] std::size_t begun() const { return next_; }
  [[nodiscard]] std::size_t width() const { return items_.size(); }

  [[nodiscard]] bool has(CifItem item) const { return has_[static_cast<std::size_t>(item)]; }
  static CifItem after(CifItem item, int steps) {
    return static_cast<CifItem>(static_cast<int>(item) + steps);
  }

  /// Returns the value without quotes. Returns "" for missing values, '.' and '?'. Valid until the
  /// next add() and the next call for the same item.
  [[nodiscard]] std::string_view text(CifItem item) const;
  /// Returns the value of `item`, or that of `other` if it is missing.
  [[nodiscard]] std::string_view text(CifItem item, CifItem other) const {
    const std::string_view preferred = text(item);
    return preferred.empty() ? text(other) : preferred;
  }
  /// Returns the name of a coordinate for messages: "cartn_x".
  static std::string_view axis_name(CifItem item);
  /// Returns a coordinate. The text may end with a standard uncertainty: 1.234(5). Throws
  /// InputError at `place` if the text is not a number.
  [[nodiscard]] double number(CifItem item, const FilePlace& place) const;
  /// Returns the number. Returns NaN for missing values and other texts.
  [[nodiscard]] double number_or_unknown(CifItem item) const;

 private:
  static constexpr auto item_count = static_cast<std::size_t>(CifItem::count);
  std::vector<CifItem> items_;  // one per column; count: ignore the column
  std::array<bool, item_count> has_{};
  std::array<std::string, item_count> texts_;
  mutable std::array<std::string, item_count> unquoted_;
  std::size_t next_ = 0;
};

/// Returns a CIF number without its uncertainty.
std::string_view without_uncertainty(std::string_view value);

/// Turns the rows of the chosen atom table into particles.
class CifSites {
 public:
  /// `place` is the position of the reader and must outlive this object.
  CifSites(const ParticleRequest& request, const FilePlace& place)
      : request_(request), place_(&place) {}

  /// Begins the table. `table` is not `other`. The columns of `row`, which has all three
  /// coordinates of a position or none, decide whether the positions are Cartesian.
  void start(CifTable table, const CifRow& row);
  [[nodiscard]] bool has_table() const { return kind_ != Kind::none; }
  [[nodiscard]] bool is_component() const { return kind_ == Kind::component; }
  void add(const CifRow& row);

  /// Returns the particles of the model that ParticleRequest::frame chooses. Frame 0 is the first
  /// model of the file, whatever its number. For a crystal, returns the content of the cell: see
  /// unit_cell(). For a component, uses ideal coordinates if all placed atoms have them. `crystal`
  /// gives the cell and the symmetry, and may be empty afterwards. Throws InputError at `place` if
  /// the file lacks the model, if no atom has a position, or as unit_cell() does.
  Particles finish(Crystal& crystal);

 private:
  enum class Kind : std::uint8_t {
    none,
    cartesian,   ///< models of macromolecules
    fractional,  ///< sites of a crystal
    component    ///< an isolated residue or ligand
  };
  /// An atom of a component. The file may give two sets of coordinates.
  struct ComponentAtom {
    std::string name;
    std::string residue;
    std::optional<Vec3d> model;
    std::optional<Vec3d> ideal;
    std::uint8_t element;
    double charge;
  };

  void add_cartesian(const CifRow& row);
  void add_fractional(const CifRow& row);
  void add_component(const CifRow& row);
  bool in_chosen_model(const CifRow& row);
  /// Fails if the file has atoms, but none has a position.
  void check_placed(std::size_t placed) const;
  Particles finish_atoms(AtomColumns& atoms) const;
  Particles finish_cartesian(const Crystal& crystal);
  Particles finish_component();

  ParticleRequest request_;
  const FilePlace* place_;
  Kind kind_ = Kind::none;
  std::optional<AtomColumns> atoms_;
  std::vector<std::string> models_;  // model numbers in the order of the file
  std::size_t model_ = 0;            // index of the row's model in models_
  std::vector<CrystalSite> sites_;
  std::vector<ComponentAtom> component_;
  std::uint64_t unplaced_ = 0;
  std::uint64_t dummies_ = 0;
};

}  // namespace parray::input
