#pragma once

#include "cli/input/formats/table_rows.h"
#include "cli/input/formats/table_shape.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Reads a table of numbers without names (TableShape::Names::none). The first three columns are x,
/// y and z. The fourth of four columns is the radius, if all its numbers are allowed radii. The
/// last three of six columns are colours (8-bit sRGB), if they are whole numbers from 0 to 255 and
/// not all 0 or 1; so are those of seven columns in a file with a count (.pts). Every other column
/// is a number on request: c4, c5 and so on. A note says how the columns were read. `rows` reads
/// from `input` and must not have read any row. Throws the errors of read_particles().
Particles read_plain_table(TableRows& rows, ParticleInput& input, const TableShape& shape,
                           const ParticleRequest& request);

}  // namespace parray::input
