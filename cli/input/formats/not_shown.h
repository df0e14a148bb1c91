#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

/// Notes about the content of files that pictures of spheres do not show.
namespace parray::input {

/// Adds the note "COUNT ellipsoids shown as spheres". Does nothing for 0 ellipsoids.
void note_ellipsoids(std::uint64_t count, ParticleFacts& facts);

/// Adds the note "COUNT line segments, triangles or bodies shown as spheres". Does nothing for 0.
void note_bodies(std::uint64_t count, ParticleFacts& facts);

/// Adds the note that `count` bonds of CIF's table _geom_bond are not read. Does nothing for 0.
void note_geometry_bonds(std::uint64_t count, ParticleFacts& facts);

/// Counts the ellipsoids in the rows of a table whose columns have LAMMPS's names: shapex, shapey,
/// shapez (diameters along three axes) and quatw (an orientation).
class EllipsoidRows {
 public:
  /// `names`: the names of the columns, in lower case.
  explicit EllipsoidRows(const std::vector<std::string_view>& names);

  /// Counts the row if its three diameters are not all equal. In a table with quatw but without
  /// diameters, every row counts. `row` has as many fields as there are names.
  void add(const std::vector<std::string_view>& row);
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::optional<std::array<std::size_t, 3>> shape_;  // columns
  bool oriented_ = false;
  std::uint64_t count_ = 0;
};

/// Returns whether three diameters are not all equal. Returns false unless all are numbers.
bool is_ellipsoid(std::string_view x, std::string_view y, std::string_view z);

}  // namespace parray::input
