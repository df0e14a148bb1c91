#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/arrows.h"
#include "cli/input/particles/bonds.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"

/// Turns a particle file into spheres and capsules: selects particles and appends them to a scene.
namespace parray::input {

/// Particles of a file that have one look.
struct ParticlePart {
  Particles particles;  ///< facts contain only the unit of length and notes on this part
  ParticleLook look;    ///< complete: see completed()
  /// Number of the representation, from 0. Nothing: the source has no representations.
  std::optional<std::size_t> representation{};
  /// For each particle of the part, its index in the particles that split() received. Empty: the
  /// part has all of them.
  std::vector<std::uint32_t> numbers{};
  // Set by parts_of():
  ParticleColors colors{};  ///< empty if its look has no `color_by`
  NumberBounds sized{};     ///< numbers with the least and the largest radius, of `radius_by`
};

/// Splits `particles` by the representations of `source`, in their order. A particle in several
/// selections belongs to the last one. Parts without particles are left out. Leaves the facts and
/// the cell in `particles`, and adds notes there: "shown_twice" counts particles in several
/// selections, "not_shown" those in none. The result is the same for any number of threads.
///
/// Throws UnknownNumber (selection.h) if a selection needs a numeric column that the particles
/// lack. Throws SourceError with the key "select" and the representation for a selection that needs
/// another missing column or that selects no particle.
std::vector<ParticlePart> split(Particles& particles, const ParticleSource& source,
                                int threads = 1);

/// Runs `work`. Adds the number of the representation to each SourceError.
void in_representation(const std::optional<std::size_t>& number, const auto& work) {
  try {
    work();
  } catch (const SourceError& error) {
    throw SourceError(error.key(), error.what(), number);
  }
}

/// The particles that a source selects.
struct SelectedParticles {
  ParticleFacts facts;  ///< of the file; the notes of the parts are not in it
  std::optional<ParticleCell> cell;
  std::vector<ParticlePart> parts{};
  std::size_t count = 0;             ///< of particles that selected() returned, shown or not
  std::vector<DrawnBond> bonds{};    ///< between particles as selected() numbered them
  double stick_radius = 0;           ///< of looks that give none; 0: no look draws sticks
  ParticleArrows arrows{};           ///< one per particle that selected() returned; empty: none
  std::filesystem::path topology{};  ///< empty: none
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
struct OpenTrajectory {
  explicit OpenTrajectory(const std::filesystem::path& path) : file(path) {}
  PackedFile file;
  FrameCursor cursor;
};
using OpenTrajectories = std::map<std::filesystem::path, OpenTrajectory>;

/// Reads the files of `file.particles` and appends their spheres and capsules to the scene, in
/// order: see append_parts(). Clears `file.particles`. Names of particle files are relative to the
/// folder of the scene file `scene_path`. Files of `open` stay open; null: none does.
///
/// Throws InputError "SCENE:LINE: /particles/INDEX/...: problem: remedy". For a source without a
/// line, which options describe, throws the errors of fail_in_options().
void expand_particles(SceneFile& file, const std::filesystem::path& scene_path, int threads = 1,
                      OpenTrajectories* open = nullptr);

}  // namespace parray::input
