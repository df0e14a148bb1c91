#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "common/base/error.h"

namespace parray::input {

/// What a table of atoms in CIF says of each, whichever dictionary names it.
enum class CifItem : std::uint8_t {
  x,  // Cartesian, angstrom
  y,
  z,
  fract_x,  // along the cell's edges
  fract_y,
  fract_z,
  ideal_x,  // of a component without its surroundings, angstrom
  ideal_y,
  ideal_z,
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
  assembly,
  occupancy,
  b_factor,
  u_factor,
  charge,
  calculated,
  model,
  count
};

/// The kinds of tables that hold atoms.
enum class CifTable : std::uint8_t {
  other,
  sites,      ///< atom_site: of macromolecules, or of crystals
  components  ///< chem_comp_atom: of one residue or ligand
};

/// In lower case, with '_' for the dot of later dictionaries: "_atom_site_cartn_x".
std::string plain_tag(std::string_view tag);

/// The table that a tag belongs to (a plain one).
CifTable table_of(std::string_view plain_tag);

/// A row of a table of atoms, of which only what counts is kept.
class CifRow {
 public:
  /// Starts a table with these plain tags.
  void start(const std::vector<std::string>& tags);

  /// The next value of the row, as it stands in the file; true: it was the row's last.
  bool add(std::string_view value) {
    const auto item = items_[next_];
    if (item != CifItem::count) texts_[static_cast<std::size_t>(item)].assign(value);
    next_ = next_ + 1 == items_.size() ? 0 : next_ + 1;
    return next_ == 0;
  }
  /// Values of a row that is not complete.
  [[nodiscard]] std::size_t begun() const { return next_; }
  [[nodiscard]] std::size_t width() const { return items_.size(); }

  [[nodiscard]] bool has(CifItem item) const { return has_[static_cast<std::size_t>(item)]; }
  /// All three of a position.
  [[nodiscard]] bool has_position(CifItem x) const {
    return has(x) && has(after(x, 1)) && has(after(x, 2));
  }
  static CifItem after(CifItem item, int steps) {
    return static_cast<CifItem>(static_cast<int>(item) + steps);
  }

  /// Without quotes; empty for what is missing, '.' or '?'. Valid until the next call for the item.
  [[nodiscard]] std::string_view text(CifItem item) const;
  [[nodiscard]] std::string_view text(CifItem item, CifItem other) const {
    const std::string_view preferred = text(item);
    return preferred.empty() ? text(other) : preferred;
  }
  /// What a table of sites calls a coordinate: "cartn_x".
  static std::string_view axis_name(CifItem axis);
  /// A coordinate. A standard uncertainty in brackets may follow: 1.234(5). Fails at `place`.
  [[nodiscard]] double number(CifItem item, const FilePlace& place) const;
  /// NaN for what is missing or no number.
  [[nodiscard]] double number_or_unknown(CifItem item) const;

 private:
  static constexpr auto item_count = static_cast<std::size_t>(CifItem::count);
  std::vector<CifItem> items_;  // by column; count: none that counts
  std::array<bool, item_count> has_{};
  std::array<std::string, item_count> texts_;
  mutable std::array<std::string, item_count> unquoted_;
  std::size_t next_ = 0;
};

/// The number that a value of CIF starts with, without its uncertainty.
std::string_view without_uncertainty(std::string_view value);

}  // namespace parray::input
