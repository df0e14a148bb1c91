#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/input/scene_file/scene_file.h"

namespace parray::commands {

/// Changes of the scene for one frame of a series. Empty: no change.
struct FrameChange {
  /// Number of the frame, from 0, to read from the particle files that a scene names. It applies to
  /// files of formats with several frames, unless the scene itself chooses a frame. An error if it
  /// applies to no file. Ignored if a particle file is loaded without a scene.
  std::optional<std::uint64_t> particles{};
  std::optional<Camera> camera{};
};

/// Which particle files and topologies a scene may name.
enum class NamedFiles : std::uint8_t {
  anywhere,
  beside,  ///< only names without a folder: files beside the scene, for uploaded scenes
};

/// Reads a scene file with its particles, or makes an automatic scene from a file of particles. The
/// contents decide which of the two a file is. Replaces settings by the options that are given.
/// Prints the notes of readers and a warning of duplicates on stderr. Throws InputError. "-" is the
/// standard input; with NamedFiles::beside it is a file of this name.
SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change = {}, NamedFiles named = NamedFiles::anywhere);

/// Returns the automatic scene of a file of particles without the particles of `frame`, which
/// determine its camera. It refers to the file: choose a frame in its only source, then call
/// complete_scene().
SceneFile automatic_scene_of_frames(const std::string& file, const RenderOptions& options,
                                    std::uint64_t frame, NamedFiles named);
/// Adds the particles that the scene refers to.
void complete_scene(SceneFile& scene, const std::string& file);

/// Returns whether the file is one of particles whose format has several frames.
bool may_hold_frames(const std::filesystem::path& path);
/// Throws InputError if the scene of `file` names a file in another folder.
void check_beside(const SceneFile& scene, const std::string& file);

/// Loads a file that is already open.
SceneFile load_scene(PackedFile& file, const RenderOptions& options, const FrameChange& change = {},
                     NamedFiles named = NamedFiles::anywhere);

}  // namespace parray::commands
