#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/particles/arrows.h"
#include "cli/input/particles/bonds.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"
#include "cli/input/particles/representations.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"

/// Turns a particle file into spheres and capsules: selects particles and appends them to a scene.
namespace parray::input {

/// The particles that a source selects.
struct SelectedParticles {
  ParticleFacts facts;  ///< of the file; the notes of the parts are not in it
  std::optional<ParticleCell> cell;
  std::vector<ParticlePart> parts{};
  std::size_t count = 0;           ///< of particles that selected() returned, shown or not
  std::vector<DrawnBond> bonds{};  ///< between particles as selected() numbered them
  double stick_radius = 0;         ///< of looks that give none; 0: no look draws sticks
  ParticleArrows arrows{};         ///< one per particle that selected() returned; empty: none
};

/// Returns what must be read from the file of `source`. A relative name of the topology is relative
/// to `folder`.
ParticleRequest request_of(const ParticleSource& source, const std::filesystem::path& folder,
                           int threads = 1);

/// Applies source.cell and source.filter to `particles`, which were read from `file` by `request`,
/// a result of request_of(). Returns the particles that the filter shows. Before that, if
/// source.cell.crystal is not given and is_crystal() is true, sets source.cell.crystal to true.
/// Reads the file again only to list its numeric columns in a message.
///
/// Throws SourceError if a member of the source does not suit the file.
Particles selected(Particles particles, PackedFile& file, ParticleSource& source,
                   const ParticleRequest& request);

/// Splits the result of selected() by the representations of `source`, and colours the parts. Finds
/// the bonds and the arrows that the source shows.
///
/// Throws SourceError if a member of the source does not suit the particles.
SelectedParticles parts_of(Particles particles, PackedFile& file, const ParticleSource& source,
                           const ParticleRequest& request);

/// Throws InputError "FILE: --OPTION: problem" for an error in a source that options describe. In a
/// representation: "FILE: --show 'SELECTION': ...". Problems with "material" and "radius" name no
/// option; without a representation, their text already names the file.
[[noreturn]] void fail_in_options(const SourceError& error, const ParticleSource& source,
                                  const std::string& file);

/// The look of particles if the file supports no automatic rule.
struct DefaultLook {
  std::string material_name;  ///< becomes a material name of the scene if the source uses it
  Material material;
  double radius = 1;
};

/// Replaces automatic rules of `source` by rules that the particles support. Appends the spheres of
/// the particles to file.scene, part by part, then capsules for bonds, arrows and the edges of the
/// cell. Appends the meaning of colours and arrows to file.legends, and facts about the particles
/// to other members of `file`. `path` is the path of the particle file; empty for the standard
/// input. Without `otherwise`, automatic rules that the file does not support are errors. Returns
/// the source with the decided rules.
///
/// Throws SourceError for "material", "radius", "color_by" and "solid_cell". Throws the errors of
/// append_spheres().
ParticleSource append_parts(SelectedParticles selected, const std::filesystem::path& path,
                            ParticleSource source, SceneFile& file, int threads,
                            const DefaultLook* otherwise = nullptr);

/// A particle file that stays open, so that reading the frames of a trajectory one after the other
/// reads the file once.
struct Trajectory {
  explicit Trajectory(const std::filesystem::path& path) : file(path) {}
  PackedFile file;
  FrameCursor cursor;
};
using OpenTrajectories = std::map<std::filesystem::path, Trajectory>;

/// Reads the files of `file.particles` and appends their spheres and capsules to the scene, in
/// order: see append_parts(). Clears `file.particles`. Names of particle files are relative to the
/// folder of the scene file `scene_path`. Files of `open` stay open; null: none does.
///
/// Throws InputError "SCENE:LINE: /particles/INDEX/...: problem: remedy". For a source without a
/// line, which options describe, throws the errors of fail_in_options().
void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads = 1,
                      OpenTrajectories* open = nullptr);

}  // namespace parray::input
