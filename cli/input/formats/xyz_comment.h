#pragma once

#include <optional>
#include <string_view>

#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

/// The comment of a frame of XYZ, whose pairs KEY=VALUE make it extended XYZ: "Extended XYZ
/// specification", github.com/libAtoms/extxyz. Values stand in quotes or brackets where they have
/// blanks.
namespace parray::input {

/// How the rows of a frame look.
struct XyzLayout {
  RowLayout row;
  std::vector<NumberField> others;  ///< numbers that a request may want
  std::size_t columns = 4;          ///< that a row must have
  bool exact = false;               ///< and no more
};

/// As Properties says or, where there are none, a name and a position. Fails at `place` for
/// Properties that cannot be understood, or have no positions.
XyzLayout xyz_layout(std::string_view comment, const FilePlace& place);

/// Lattice and Origin; nothing where they are no cell.
std::optional<ParticleCell> xyz_cell(std::string_view comment);

/// Time, or else the step; also that of LAMMPS's own comment.
std::optional<double> xyz_time(std::string_view comment);

/// LAMMPS's own comment: its names are numbers of types, unless somebody has set others.
bool is_lammps_comment(std::string_view comment);

}  // namespace parray::input
