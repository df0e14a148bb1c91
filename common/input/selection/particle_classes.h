#pragma once

#include <string_view>

#include "common/input/particles/particles.h"
#include "common/input/selection/selection.h"

namespace parray {

/// A residue of that name is of the kind: "water", "protein", "nucleic" or "ion".
bool is_residue_of(std::string_view kind, std::string_view residue_name);

/// The one-letter code of an amino acid, or of a nucleotide's base; 0: it is none.
char amino_acid_letter(std::string_view residue_name);
char nucleotide_letter(std::string_view residue_name);

/// Particles that stand for no atom, such as the charge M of a four-site water. Empty: there are
/// none.
ParticleMask virtual_sites(const Particles& particles);

}  // namespace parray
