#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "cli/input/scene_file/scene_file.h"

/// Looks that are the same in all frames of a film: colours, legends, ranges of numbers and sizes.
namespace parray::input {

/// Adds look.coloring.names to the column of names that decides the colours, before the names of
/// the particles. So the same name has the same colour whichever other names a frame contains.
void add_names(const ParticleLook& look, Particles& particles);

/// Collects the values on which looks depend, such as the least and the largest number, over all
/// frames of a film. Then gives every frame the same values.
class FixedLooks {
 public:
  /// Adds the particle files of a frame, in the order of the scene's sources: file i belongs to
  /// source i.
  void add(const std::vector<ParticleFile>& files);
  /// Makes the looks of the sources independent of the frame. Numbers at the ends of a colour map,
  /// or with the least and the largest radius, become the least and the largest ones of all frames.
  /// With percentages, each frame contributes its own percentiles. Sticks without elements get the
  /// default radius of the first frame that has some. Arrows get the ArrowMeasure of all frames.
  /// `sources` are those of a frame, in the same order. Returns whether the sizes of shapes may
  /// have changed.
  bool apply_to(std::vector<ParticleSource>& sources) const;

 private:
  struct Sizes {
    double stick_radius = 0;
    ArrowMeasure arrows{};
  };
  using Place = std::pair<std::size_t, std::optional<std::size_t>>;  ///< source, representation
  std::map<Place, PartLook> looks_;
  std::map<std::size_t, Sizes> sizes_;  // by source
};

}  // namespace parray::input
