#pragma once

#include <optional>
#include <string>

#include "cli/input/scene_file/particle_source.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// Options that select, colour and scale the particles of a file. An option that is absent leaves
/// the source as it is.
class ParticleOptions {
 public:
  /// Declares the options. The object must not move while the command line is parsed.
  void add_to(Command& command);
  /// Throws InputError that names the options given: the scene `file` is not a particle file.
  void check_unused(const std::string& file) const;
  /// Lays the options over `source`. Throws InputError if options exclude each other.
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
