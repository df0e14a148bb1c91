#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "cli/input/scene_file/scene_file.h"

/// Looks that are the same in all frames of a film: colours, ranges of numbers and radii.
namespace parray::input {

/// Adds look.coloring.names to the column of names that decides the colours, before the names of
/// the particles. So the same name has the same colour whichever other names a frame contains.
void add_names(const ParticleLook& look, Particles& particles);

/// Collects what looks depend on over the frames of a film, and fixes it.
class FixedLooks {
 public:
  /// Adds the particle files of a frame, in the order of the scene's sources.
  void add(const std::vector<ParticleFile>& files);
  /// Makes the looks of the sources independent of the frame. Numbers at the ends of a colour map,
  /// or with the least and the largest radius, become the extremes of those of all frames. With
  /// percentages, each frame contributes its own percentiles.
  void apply_to(std::vector<ParticleSource>& sources) const;

 private:
  using Place = std::pair<std::size_t, std::optional<std::size_t>>;  ///< source, representation
  std::map<Place, PartLook> looks_;
};

}  // namespace parray::input
