#pragma once

#include <optional>
#include <string>

#include "cli/input/scene_file/particle_source.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// What of a file of particles is shown, and how. What is not given stays as the source has it.
class ParticleOptions {
 public:
  /// They must stay where they are while the command line is parsed.
  void add_to(Command& command);
  /// Throws InputError that names those given: the scene `file` is not a file of particles.
  void check_unused(const std::string& file) const;
  /// Throws InputError where options do not go together.
  [[nodiscard]] ParticleSource over(ParticleSource source) const;

 private:
  void add_filter_to(Command& command);
  void add_coloring_to(Command& command);

  std::optional<FrameChoice> frame_;
  std::string topology_;
  std::optional<AlternativeChoice> alternatives_;
  ParticleMaterial material_;
  ParticleRadius radius_;
  ParticleFilter filter_;
  ParticleColoring coloring_;
};

}  // namespace parray::commands
