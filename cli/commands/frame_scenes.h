#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/input/scene_file/scene_file.h"

namespace parray::commands {

/// Loads the scenes of the frames of a trajectory. The trajectory is a file of particles, or is
/// named by a scene file. A file of particles alone gets one automatic camera for all frames: that
/// of the first one. Throws the errors of load_scene().
class FrameScenes {
 public:
  /// `options` must outlive this object.
  FrameScenes(std::string file, const RenderOptions& options, NamedFiles named);

  /// Counts the frames of the trajectory. Throws InputError if the scene names no trajectory, or
  /// chooses a frame itself.
  [[nodiscard]] std::uint64_t count() const;
  /// Sets the frame that determines the automatic camera. Call before at().
  void begin_at(std::uint64_t frame) { first_ = frame; }
  /// Returns the scene of a frame.
  SceneFile at(std::uint64_t frame);

  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  const std::string file_;
  const RenderOptions& options_;
  const NamedFiles named_;
  bool is_scene_ = false;  ///< the file is a scene, not a file of particles
  std::uint64_t first_ = 0;
  std::optional<SceneFile> shared_;  ///< the automatic scene without its particles
};

}  // namespace parray::commands
