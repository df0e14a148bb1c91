#include "cli/commands/loading.h"

#include <utility>

#include "cli/commands/printing.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/settings.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;

/// Throws InputError if a file that `where` names is in another folder.
void check_is_beside(const std::string& named, const std::string& where) {
  if (fs::path(named).filename() == named) return;
  throw InputError(
      where + ": '" + printable(named) +
      "' is a path: send the file as a part of the same form, and write only its name");
}

/// Completes a scene whose particles were added after its file was read: removes their duplicates,
/// and gives the materials the order, and so the scene the identity, of a file with all spheres.
void tidy(SceneFile& scene, int threads) {
  const Duplicates more = remove_duplicates(scene.scene, threads);
  if (scene.duplicates.count == 0) {
    scene.duplicates = more;
  } else {
    scene.duplicates.count += more.count;
  }
  if (!scene.scene.capsules.empty()) order_materials(scene.scene);
}

AutoScene automatic_scene(PackedFile& file, const ParticleSource& source,
                          const RenderOptions& options, const Viewing& viewing, NamedFiles named) {
  if (named == NamedFiles::beside) check_is_beside(source.topology, "--topology");
  RenderSettings settings = auto_scene_settings();
  if (options.can_stop()) settings.target_error = auto_scene_error;
  AutoScene scene = auto_scene(file, source, options.over(settings), viewing, usable_cpus());
  scene.file.background = options.auto_scene().background();
  scene.file.transparent = viewing.transparent;
  return scene;
}

SceneFile read_any(PackedFile& file, const RenderOptions& options, const FrameChange& change,
                   NamedFiles named) {
  const std::string& name = file.name();
  if (particle_format_of(file) != nullptr) {
    SceneFile scene = automatic_scene(file, options, named).file;
    tidy(scene, usable_cpus());
    return scene;
  }
  SceneFile scene = scene_without_particles(file, options, named);
  if (change.particles && !choose_frame(scene, *change.particles, name)) {
    throw InputError(printable(name, 4096) +
                     ": all frames would be equal: write #### for the frame's number in the "
                     "scene's name, add --camera-path, or use a scene with a trajectory");
  }
  if (!scene.particles.empty()) complete_scene(scene, name);
  return scene;
}

}  // namespace

AutoScene automatic_scene(PackedFile& file, const RenderOptions& options, NamedFiles named) {
  return automatic_scene(file, options.particles().source(), options, viewing_of(options), named);
}

bool may_hold_frames(const fs::path& path) {
  PackedFile file(path);
  const ParticleFormat* const format = particle_format_of(file);
  return format != nullptr && format->frames;
}

SceneFile read_scene(PackedFile& file, NamedFiles named) {
  SceneFile scene = read_scene_file(file, usable_cpus());
  if (named == NamedFiles::anywhere) return scene;
  for (const ParticleSource& source : scene.particles) {
    const std::string where =
        printable(file.name(), 4096) + ":" + std::to_string(source.line_of("file"));
    check_is_beside(source.file, where);
    check_is_beside(source.topology, where);
  }
  return scene;
}

bool choose_frame(SceneFile& scene, std::uint64_t frame, const std::string& file) {
  bool chosen = false;
  for (ParticleSource& source : scene.particles) {
    if (!source.frame && may_hold_frames(fs::path(file).parent_path() / source.file)) {
      source.frame = FrameChoice{frame, false};
      chosen = true;
    }
  }
  return chosen;
}

Viewing viewing_of(const RenderOptions& options) {
  Viewing viewing = options.auto_scene().viewing();
  viewing.transparent = options.transparent(false) || options.auto_scene().background().has_value();
  if (!viewing.labels) {
    viewing.labels = [](const SceneFile& file) { return LabelOptions().places(file); };
  }
  return viewing;
}

SceneOfFrames automatic_scene_of_frames(const std::string& file, const RenderOptions& options,
                                        const ParticleSource& source, const Viewing& viewing,
                                        NamedFiles named) {
  PackedFile opened{fs::path(file)};
  AutoScene made = automatic_scene(opened, source, options, viewing, named);
  const TurnAxis axis = made.axis;
  SceneFile scene = with_reference(std::move(made), fs::path(file).filename().string());
  // complete_scene() sets these anew.
  scene.particle_files.clear();
  scene.legends.clear();
  scene.cell.reset();
  return {std::move(scene), axis};
}

SceneFile scene_without_particles(PackedFile& file, const RenderOptions& options,
                                  NamedFiles named) {
  options.particles().check_unused(file.name());
  options.auto_scene().check_unused(file.name());
  SceneFile scene = read_scene(file, named);
  scene.settings = options.over(scene.settings);
  scene.transparent = options.transparent(scene.transparent);
  return scene;
}

void complete_scene(SceneFile& scene, const std::string& file, OpenTrajectories* open) {
  expand_particles(scene, file, usable_cpus(), open);
  tidy(scene, usable_cpus());
}

InputFiles inputs_of(const SceneFile& scene) {
  InputFiles inputs;
  for (const ParticleFile& file : scene.particle_files) {
    inputs.add(file.path);
    inputs.add(file.topology);
  }
  return inputs;
}

SceneFile load_scene(PackedFile& file, const RenderOptions& options, const FrameChange& change,
                     NamedFiles named) {
  SceneFile scene = read_any(file, options, change, named);
  if (change.camera) scene.scene.camera = *change.camera;
  print_notes(scene.particle_files);
  warn_of_duplicates(scene.duplicates, file.name());
  return scene;
}

SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change, NamedFiles named) {
  if (named == NamedFiles::beside) {
    PackedFile opened{fs::path(file)};  // "-" would be this process's own standard input
    return load_scene(opened, options, change, named);
  }
  PackedFile opened = PackedFile::of_argument(file);
  return load_scene(opened, options, change, named);
}

}  // namespace parray::commands
