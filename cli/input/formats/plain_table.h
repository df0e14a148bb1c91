#pragma once

#include "cli/input/formats/table_rows.h"
#include "cli/input/formats/table_shape.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Reads a table of numbers without names (TableShape::Names::none). The first three columns are x,
/// y and z. The fourth of four columns is the radius, if all its numbers are allowed radii. The
/// last three columns are colours (8-bit sRGB) if there are six columns, or seven in a file with a
/// count (.pts), and if these three are whole numbers from 0 to 255 and not all 0 or 1. Every other
/// column is numeric, with the name c4, c5 and so on, and is read if the request wants it. A note
/// says how the columns were read. `rows` reads from `input` and must not have read any row. Throws
/// the errors of read_particles().
Particles read_plain_table(TableRows& rows, ParticleInput& input, const TableShape& shape,
                           const ParticleRequest& request);

}  // namespace parray::input
