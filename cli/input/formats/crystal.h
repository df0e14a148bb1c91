#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/symmetry_operation.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// A site of the asymmetric unit.
struct CrystalSite {
  Vec3d fraction;  ///< along the cell's edges
  std::string label;
  std::uint8_t element = 0;
  std::string group;     ///< of disorder; empty: none
  std::string assembly;  ///< of groups that exclude each other
  double occupancy = 1;
  double b_factor = 0;  ///< angstrom^2; NaN: not known
};

/// What CIF says of a crystal: cif_core, Hall, Allen and Brown, Acta Cryst. A47 (1991) 655.
struct Crystal {
  std::vector<CrystalSite> sites;
  Vec3d lengths;  ///< of the cell, angstrom; 0: not known
  Vec3d angles{90, 90, 90};
  std::vector<std::string> operations;  ///< "x,y,z", as the file lists them
  std::string space_group;              ///< where it lists none: its symbol or number
};

/// The content of one cell, with fractions in [0, 1): every site under every operation of symmetry,
/// once where operations bring it back to within 0.4 angstrom (as gemmi has it). Of sites that
/// exclude each other (groups of disorder in one assembly, sites at one place) the choice says
/// which are there. Numbers: occupancy, b_factor. Fails at `place`.
Particles unit_cell(Crystal crystal, const ParticleRequest& request, const FilePlace& place);

}  // namespace parray::input
