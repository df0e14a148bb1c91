#pragma once

#include <cstddef>
#include <vector>

#include "cli/input/particles/selected_particles.h"
#include "cli/input/particles/sticks.h"
#include "common/scene/scene.h"

namespace parray::input {

/// Turns the spheres of a source's particles into the shapes that the source asks for.
class ParticleShapes {
 public:
  /// Begins before the first sphere of the source. All arguments must outlive the object.
  ParticleShapes(const SelectedParticles& selected, const ParticleSource& source, Scene& scene);

  /// Call it after append_spheres() for each part. Changes the radii of the spheres of `part`, the
  /// last ones in the scene, by the style of its look, whose automatic rules were replaced: see
  /// shape_spheres().
  void add_part(const SelectedPart& part);

  /// Appends the capsules after the last part: those of bonds (append_sticks()), then those of the
  /// arrows in the order of particles, then the edges of the cell if `solid_cell` is set.
  ///
  /// Throws SourceError for "solid_cell" without a cell. Throws InputError "FILE: problem: remedy"
  /// if shapes exceed limits.h; the scene is unusable then.
  void append_capsules();

 private:
  void append_arrows();
  void append_edges();
  void check_limits(std::size_t first_capsule) const;

  const SelectedParticles& selected_;
  const ParticleSource& source_;
  Scene& scene_;
  std::size_t first_;                     // sphere of the next part
  std::vector<DrawnParticle> particles_;  // empty without bonds and arrows
};

}  // namespace parray::input
