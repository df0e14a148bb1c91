#pragma once

#include <string_view>

#include "cli/input/color/particle_paint.h"

namespace parray::input {

/// Colours by one of color_by_words. Elements have their own colours; types, chains and atom names
/// those of category_color(), in the order in which the file first uses them, so that a selection
/// changes none. Residues: see residue_groups.h.
///
/// Throws SourceError("color_by") where the particles lack the column.
ParticlePaint painted_by_category(std::string_view word, const Particles& particles);

}  // namespace parray::input
