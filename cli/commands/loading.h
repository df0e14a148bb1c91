#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/input/scene_file/scene_file.h"

namespace parray::commands {

/// What a frame of a series has of its own; by default nothing.
struct FrameChange {
  /// Of the particle files that may hold several, but for those whose frame the scene names.
  std::optional<std::uint64_t> particles{};
  std::optional<Camera> camera{};
};

/// Which particle files a scene may name.
enum class NamedFiles : std::uint8_t {
  anywhere,
  beside,  ///< those in the scene's own folder: somebody else has written the scene
};

/// The scene in a scene file, its particles among its spheres, or the portrait of a particle file;
/// with the options laid over its settings. Which of them a file is, its contents say. Tells on
/// stderr what readers have guessed, dropped or left out, and of duplicates. Throws InputError.
/// "-" is the standard input, unless the scene is somebody else's.
SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change = {}, NamedFiles named = NamedFiles::anywhere);

/// The same of a file that is open.
SceneFile load_scene(PackedFile& file, const RenderOptions& options, const FrameChange& change = {},
                     NamedFiles named = NamedFiles::anywhere);

}  // namespace parray::commands
