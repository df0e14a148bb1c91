#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "cli/input/particles/cell.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// What happens to particles in a periodic cell before the filter chooses from them.
struct CellOperations {
  /// Whether particles are drawn as a crystal. Not given: is_crystal() decides in automatic scenes;
  /// particles of a scene file are no crystal.
  std::optional<bool> crystal{};
  Replicas replicate{};  ///< how often the cell is repeated along its edges
  bool wrap = false;     ///< moves particles into the cell
  bool whole = false;    ///< joins molecules that the faces of the cell break
  std::string center{};  ///< selection whose centroid moves to the centre of the cell; empty: none

  friend bool operator==(const CellOperations&, const CellOperations&) = default;
};

/// Most atoms of a crystal that is_crystal() recognises.
inline constexpr std::size_t most_crystal_atoms = 500;

/// Returns whether the particles look like a crystal: a cell that is periodic along an edge, no
/// residues, no chains and at most most_crystal_atoms atoms.
bool is_crystal(const Particles& particles);

/// Applies the operations in this order: whole, center, wrap, replicate, copies of a crystal's
/// atoms on opposite faces. `center` also wraps. With `whole`, wrapping moves whole molecules.
/// Notes count the copies on faces ("boundary_copies") and the molecules that bond to their own
/// images in neighbouring cells ("endless_molecules").
///
/// Throws UnknownNumber if `center` uses a numeric column that the particles lack. Throws
/// SourceError with the key of an operation if the particles lack what it needs, if there would be
/// too many copies, or if a coordinate would be above limits::max_length.
void apply(const CellOperations& operations, Particles& particles, int threads = 1);

}  // namespace parray::input
