#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/auto_scene.h"
#include "cli/input/view/surroundings.h"
#include "cli/output/input_files.h"

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
/// Prints the notes of readers (print_notes()) and a warning of duplicates on stderr. Throws
/// InputError. "-" is the standard input; with NamedFiles::beside it is a file of this name.
SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change = {}, NamedFiles named = NamedFiles::anywhere);

/// Returns how an automatic scene shows its particles by these options. If the command has no
/// options for labels, the camera makes room for the usual ones, so that all commands make the same
/// scene.
Viewing viewing_of(const RenderOptions& options);

/// Makes the automatic scene of an open file of particles by these options. Throws InputError.
AutoScene automatic_scene(PackedFile& file, const RenderOptions& options, NamedFiles named);

/// An automatic scene without its particles. It refers to their file in its only source.
struct SceneOfFrames {
  SceneFile scene;
  TurnAxis axis;  ///< of a turntable; see Surroundings
};
/// Returns the automatic scene of a file of particles for several frames. The particles of `source`
/// determine the direction of view. Choose a frame in the scene's source, then call
/// complete_scene().
SceneOfFrames automatic_scene_of_frames(const std::string& file, const RenderOptions& options,
                                        const ParticleSource& source, const Viewing& viewing,
                                        NamedFiles named);
/// Returns the scene of a scene file with the options laid over its settings, but without the
/// particles to which it refers. Call complete_scene() to add the particles.
SceneFile scene_without_particles(PackedFile& file, const RenderOptions& options, NamedFiles named);
/// Chooses a frame of each trajectory that the scene of `file` names, unless the scene itself does.
/// Returns false if that chooses no frame.
[[nodiscard]] bool choose_frame(SceneFile& scene, std::uint64_t frame, const std::string& file);
/// Adds the particles to which the scene refers. `open`: see expand_particles().
void complete_scene(SceneFile& scene, const std::string& file, OpenTrajectories* open = nullptr);

/// Returns whether the file is one of particles whose format has several frames.
bool may_hold_frames(const std::filesystem::path& path);
/// Reads a scene file without its particles, and without any options. Throws InputError, also if
/// the scene names a file that `named` does not allow.
SceneFile read_scene(PackedFile& file, NamedFiles named);

/// Returns the particle files and topologies of a scene whose particles were read.
InputFiles inputs_of(const SceneFile& scene);

/// Loads a file that is already open.
SceneFile load_scene(PackedFile& file, const RenderOptions& options, const FrameChange& change = {},
                     NamedFiles named = NamedFiles::anywhere);

}  // namespace parray::commands
