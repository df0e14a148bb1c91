#include "cli/input/formats/binary_frame.h"

#include <string>

#include "cli/input/formats/readers.h"
#include "cli/input/particles/particle_columns.h"
#include "common/scene/limits.h"

namespace parray::input {

std::uint64_t checked_atoms(std::int64_t count, const FilePlace& place) {
  if (count < 0 || static_cast<std::uint64_t>(count) > limits::max_spheres) {
    place.fail(std::to_string(count) + " atoms: is the file damaged? At most " +
               std::to_string(limits::max_spheres) + " are read");
  }
  return static_cast<std::uint64_t>(count);
}

Particles frame_of(const std::vector<Vec3d>& positions, const FilePlace& place) {
  ParticleColumns columns(place);
  columns.expect(positions.size());
  for (const Vec3d& position : positions) columns.position(position);
  return columns.finish_frame();
}

ParticleNote nm_note(const Particles& particles) {
  return {"length_unit", particles.count(), nm_text};
}

}  // namespace parray::input
