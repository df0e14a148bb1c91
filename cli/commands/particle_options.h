#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/particle_source.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// Options that select, colour and scale the particles of a file.
class ParticleOptions {
 public:
  /// Declares the options. The object must not move while the command line is parsed.
  void add_to(Command& command);
  /// Sets the style of the particles or, after --show, that of the last representation.
  void set_style(ParticleStyle style) { given_.look.style = style; }
  /// Call for a scene that is not a particle file. Throws InputError if any of the options is
  /// given. `file`: the scene's name in the message.
  void check_unused(const std::string& file) const;
  /// Returns the source that the options describe, without a file. Throws InputError if options
  /// exclude each other.
  [[nodiscard]] ParticleSource source() const;

 private:
  void begin_representation(const std::string& select);

  ParticleSource given_;                ///< its look collects the options after the last --show
  ParticleLook base_;                   ///< the options before the first --show
  std::vector<std::string_view> keys_;  ///< keys of the options given
};

}  // namespace parray::commands
