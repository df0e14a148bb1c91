#pragma once

#include <cstdint>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Atomic numbers of particles that have these masses (unified atomic mass units); 0: no element.
/// Masses are those of IUPAC, "Standard atomic weights of the elements 2021", as programs round
/// them. None is an element where no mass is that of one beyond helium: such files are in reduced
/// units, whose masses are 1.
std::vector<std::uint8_t> elements_of_masses(const std::vector<double>& masses);

/// Says so of `count` particles.
ParticleNote masses_note(std::uint64_t count);

/// Gives particles without elements those of the masses of their types, with a note. `masses` has
/// one for each of particles.types.names; NaN: unknown.
void take_elements_of_masses(const std::vector<double>& masses, Particles& particles);

}  // namespace parray::input
