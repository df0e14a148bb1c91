#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/duplicates.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/postprocessing.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

namespace parray::input {

class PackedFile;

/// The keys at the top level of a scene file.
inline constexpr std::array<std::string_view, 12> scene_keys{
    "version",   "camera",    "image",   "render",   "style",     "sky",
    "finishing", "materials", "spheres", "capsules", "particles", "labels"};

/// The values on which the colours and sizes of a part of a file's particles (those of one
/// representation) depend, taken from all particles of the part. In a film, fixed_looks.h makes
/// them the same for all frames.
struct PartLook {
  std::optional<std::size_t> representation{};  ///< nothing: the source has none
  NumberBounds colored{};                       ///< numbers at the ends of the colour map
  NumberBounds sized{};                         ///< numbers with the least and the largest radius
  std::vector<std::string> names{};             ///< names of the entries of its legend
};

/// A particle file that is part of a scene.
struct ParticleFile {
  std::filesystem::path path;      ///< empty: the standard input
  std::filesystem::path topology;  ///< empty: none
  ParticleSource source;    ///< refers to the file; has rules that were used for automatic ones
  std::uint64_t count = 0;  ///< number of particles in the scene
  ParticleFacts facts;      ///< with the notes of all its parts
  std::vector<PartLook> looks{};  ///< of its parts with particles
  double stick_radius = 0;        ///< default of sticks without elements; 0: there are none
  ArrowMeasure arrow_measure{};   ///< `longest` is 0 if the file has no arrows
};

/// The content of a scene file: the scene and its settings. Settings that the file does not name
/// keep the defaults of RenderSettings: 1200 x 800 pixels, 500 samples per pixel, paths of at most
/// 10 segments. These are the settings of the seed program, from which ParRay developed.
struct SceneFile {
  Scene scene;
  Boxed<RenderSettings> settings;
  bool transparent = false;  ///< pictures have no background
  /// Colour of the background in 8-bit pictures, linear RGB; such a scene is transparent. Only for
  /// automatic scenes. Not given: the picture keeps its background.
  std::optional<Vec3d> background{};
  bool seed_format = false;  ///< true: the seed program's format, recognised by its shape
  MaterialNames materials;   ///< the section `materials`; empty for the seed format
  /// Particle files that are not in the scene yet: see expand_particles() in selected_particles.h.
  std::vector<ParticleSource> particles;
  Postprocessing postprocessing;  ///< postprocessing of the picture
  LabelSettings labels;           ///< labels on the picture
  // Facts about the particles, known when their shapes are part of the scene:
  std::vector<Legend> legends;               ///< meaning of the particles' colours and arrows
  std::vector<ParticleFile> particle_files;  ///< in the order of `particles`
  std::optional<ParticleCell> cell;          ///< of the first file with a cell
  /// True: the label `cell` is set because the particles are a crystal. It is left out, without an
  /// error, if the picture is too small for it.
  bool cell_if_it_fits = false;
  bool solid_cell = false;  ///< the scene has capsules for the edges of `cell`
  /// Number of spheres at the start that are the scenery of an automatic scene.
  std::uint32_t scenery = 0;
  Duplicates duplicates;  ///< the spheres of the file that were removed
};

/// Reads scene JSON v1 (scenes/schema/scene.v1.schema.json) or the seed program's format.
///
/// Unknown, missing and duplicate keys, wrong types, numbers out of range and invalid cameras are
/// errors. Removes spheres with the centre and radius of an earlier one, so that every command and
/// the scene's identity use the same scene. Never stores the spheres as JSON. The result is the
/// same for any number of threads. Throws InputError "FILE:LINE: /json/pointer: problem: remedy".
/// LINE and pointer are missing if the file cannot be read.
SceneFile read_scene_file(const std::filesystem::path& path, int threads = 1);

/// Does the same for an open file.
SceneFile read_scene_file(PackedFile& file, int threads = 1);

/// Does the same for an open stream. `name` stands for the file in messages.
SceneFile read_scene(std::istream& input, const std::string& name, int threads = 1);

/// Writes scene JSON v1 (scenes/schema/scene.v1.schema.json), one shape per line. Writes numbers in
/// the shortest form that reads back as the same number. So read_scene() of the text gives an equal
/// scene (if the scene has no duplicate spheres) and equal width, height, samples, depth and seed.
///
/// Materials keep the names of `file.materials`. Other materials are called "material 0" and so on.
/// Files of `file.particles` stay references.
///
/// Calls `poll` many times a second and passes on its exceptions, so that the caller can stop the
/// writer. The caller must check the state of the stream. Throws InputError for a name or a text
/// that is not UTF-8.
void write_scene(std::ostream& out, const SceneFile& file, const std::function<void()>& poll);

}  // namespace parray::input
