#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Maps fractions to fractions: three rows of a 3 x 3 matrix, each followed by the translation.
using SymmetryOperation = std::array<double, 12>;

/// Parses "x, y+1/2, -z" or "-Y,X-Y,Z+0.333" (International Tables for Crystallography, volume A).
/// Returns nothing for other texts.
std::optional<SymmetryOperation> symmetry_operation_in(std::string_view text);

/// A site of the asymmetric unit.
struct CrystalSite {
  Vec3d fraction;  ///< fractions of the cell's edges
  std::string label;
  std::uint8_t element = 0;  ///< atomic number; 0: unknown
  std::string group;         ///< disorder group; empty: none
  std::string assembly;      ///< groups of the same assembly exclude each other
  double occupancy = 1;
  double b_factor = 0;  ///< angstrom^2; NaN: not known
};

/// The crystal of a CIF: cif_core, Hall, Allen and Brown, Acta Cryst. A47 (1991) 655.
struct Crystal {
  std::vector<CrystalSite> sites;
  Vec3d lengths;                        ///< lengths of the cell's edges, angstrom; 0: not known
  Vec3d angles{90, 90, 90};             ///< alpha, beta, gamma, degrees
  std::vector<std::string> operations;  ///< "x,y,z", as in the file
  std::string space_group;              ///< symbol or number, used if the file has no operations
};

/// Returns the content of one cell: positions in angstrom whose fractions of the cell are in [0,
/// 1). Applies each symmetry operation to each site. Without a known symmetry, returns only the
/// sites, and a note counts them. Images of a site within 0.4 angstrom of each other count as one,
/// as in gemmi. Groups of disorder in one assembly exclude each other: request.alternatives chooses
/// one of them. If several sites are at one place, the site with the highest occupancy stays. The
/// choice `all` keeps all sites. The numeric columns are occupancy and b_factor, if the request
/// wants them.
///
/// Throws InputError at `place` if the cell is not valid, if an operation is not valid, for more
/// than 1000 operations, and for a crystal without sites.
Particles unit_cell(Crystal crystal, const ParticleRequest& request, const FilePlace& place);

}  // namespace parray::input
