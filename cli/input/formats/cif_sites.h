#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/cif_row.h"
#include "cli/input/formats/crystal.h"

namespace parray::input {

/// The rows of the one table of atoms that is read.
class CifSites {
 public:
  /// `place` is where the reader stands; it must outlive this.
  CifSites(const ParticleRequest& request, const FilePlace& place)
      : request_(request), place_(&place) {}

  /// Of the columns that `row` has.
  void start(CifTable table, const CifRow& row);
  [[nodiscard]] bool has_table() const { return kind_ != Kind::none; }
  void add(const CifRow& row);

  /// The model that the request chooses; of a crystal the cell's content: `crystal` has its cell
  /// and symmetry.
  Particles finish(Crystal& crystal);

 private:
  enum class Kind : std::uint8_t {
    none,
    cartesian,   ///< models of macromolecules
    fractional,  ///< sites of a crystal
    component    ///< a residue or ligand by itself
  };
  /// An atom of a component, of which two sets of coordinates may be given.
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
  Particles finish_cartesian(const Crystal& crystal);
  Particles finish_component();

  ParticleRequest request_;
  const FilePlace* place_;
  Kind kind_ = Kind::none;
  std::optional<AtomColumns> atoms_;
  std::vector<std::string> models_;  // their numbers, in the order of the file
  std::size_t model_ = 0;            // the row's
  std::vector<CrystalSite> sites_;
  std::vector<ComponentAtom> component_;
  std::uint64_t unplaced_ = 0;
  std::uint64_t dummies_ = 0;
};

}  // namespace parray::input
