#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "cli/input/particles/cell.h"
#include "cli/input/particles/particles.h"
#include "common/math/vec.h"
#include "tests/support/rooms.h"

namespace parray::test {

inline Particles atoms_at(std::vector<Vec3d> positions, std::vector<std::uint8_t> elements) {
  Particles particles;
  particles.positions = std::move(positions);
  particles.elements = std::move(elements);
  return particles;
}

inline ParticleCell cubic_cell(double edge) { return *cell_from({edge, edge, edge}, {90, 90, 90}); }

}  // namespace parray::test
