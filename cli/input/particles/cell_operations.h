#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/cell.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Names of the numbers that make_whole() uses if the file has no elements.
inline constexpr std::array<std::string_view, 2> molecule_numbers{"mol", "molecule"};

/// The molecules of particles.
struct Molecules {
  std::vector<std::uint32_t> of;  ///< number of each particle's molecule, from 0
  std::uint64_t endless = 0;      ///< molecules that bond to their own images, as in crystals
};

/// Moves particles by whole edges of their cell, which they must have, so that no face of the cell
/// breaks a molecule. The first particle of each molecule stays where it is. Endless molecules stay
/// as they are, and each of their atoms counts as a molecule.
///
/// If the file has elements, molecules follow from covalent_bonds(). Otherwise they follow from the
/// numbers `mol` or `molecule`, or from residues. In these cases each particle moves to the image
/// nearest to the particle before it in the same molecule, in the order of the numbers `id`, if the
/// particles have them.
///
/// Throws InputError, which names no place, if the particles have none of these columns. Passes on
/// the errors of covalent_bonds().
Molecules make_whole(Particles& particles);

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
