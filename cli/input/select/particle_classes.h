#pragma once

#include <cstdint>
#include <string_view>

#include "cli/input/particles/particle_mask.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// What particles of molecules are, by the names of their residues and atoms: see residues.h.
enum class ParticleClass : std::uint8_t { water, protein, nucleic, ion, virtual_site };

/// "water", "protein", "nucleic", "ion".
ParticleClass class_of(std::string_view word);

/// The particles of a class. Empty when no particle can be of it: none has the names that tell.
ParticleMask class_mask(ParticleClass wanted, const Particles& particles);

}  // namespace parray::input
