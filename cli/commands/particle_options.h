#pragma once

#include <string>
#include <string_view>
#include <vector>

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
  [[nodiscard]] bool is_given(std::string_view key) const;

  ParticleSource given_;
  std::vector<std::string_view> keys_;  ///< keys of the options given
};

}  // namespace parray::commands
