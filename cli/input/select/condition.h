#pragma once

#include <string_view>

#include "cli/input/particles/particles.h"
#include "cli/input/select/expression.h"

namespace parray::input {

/// Returns a mask with 1 for each particle that satisfies `expression`, which must be a condition,
/// not a number. Throws the errors of Selection::mask() (selection.h).
ParticleMask mask_of(const Expression& expression, const Particles& particles, int threads);

/// Returns a mask with 1 for each particle of a class of molecules: "water", "protein", "nucleic",
/// "ion" or "virtual" (virtual sites). residues.h defines them by residue and atom names. The mask
/// has size 0 if no particle belongs to the class.
ParticleMask class_mask(std::string_view word, const Particles& particles);

}  // namespace parray::input
