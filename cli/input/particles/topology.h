#pragma once

#include <filesystem>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Gives particles what the file `topology` says of the same atoms: elements, names, residues,
/// radii and colours, and the numbers that the request wants. What it does not say stays. Where it
/// numbers its atoms (column "id", as LAMMPS does in files of any order), particle i is the one of
/// the i-th number, or of the same number where the particles have such a column, too.
///
/// Throws InputError when it has another number of atoms, with `file`, that of the particles.
void take_topology(const std::filesystem::path& topology, const std::filesystem::path& file,
                   const ParticleRequest& request, Particles& particles);

}  // namespace parray::input
