#include "cli/commands/loading.h"

#include <filesystem>

#include "cli/commands/printing.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/particles/expand.h"
#include "common/input/portrait/portrait_scene.h"

namespace parray {
namespace {

void choose_frame(SceneFile& scene, std::uint64_t frame, const std::string& file) {
  bool chosen = false;
  for (ParticleSource& source : scene.particles) {
    if (!source.frame && may_hold_frames(source.file)) {
      source.frame = FrameChoice{frame, false};
      chosen = true;
    }
  }
  if (!chosen) {
    throw InputError(printable(file, 4096) +
                     ": nothing in it changes from frame to frame: write #### for the number in "
                     "the scene's name, add --camera-path, or let the scene have a trajectory");
  }
}

void check_beside(const SceneFile& scene, const std::string& file) {
  for (const ParticleSource& source : scene.particles) {
    if (std::filesystem::path(source.file).filename() != source.file) {
      throw InputError(printable(file, 4096) + ":" + std::to_string(source.file_line) + ": '" +
                       printable(source.file) +
                       "' is a path: send the file beside the scene and write its name alone");
    }
  }
}

/// Looks for duplicates where spheres have been added since the reader of the scene file has.
void remove_more_duplicates(SceneFile& scene, int threads) {
  const Duplicates more = remove_duplicates(scene.scene, threads);
  if (scene.duplicates.count == 0) {
    scene.duplicates = more;
  } else {
    scene.duplicates.count += more.count;
  }
}

SceneFile read_any(const std::string& file, const RenderOptions& options, const FrameChange& change,
                   NamedFiles named, int threads) {
  if (is_particle_file(file)) {
    SceneFile portrait = portrait_scene(file, options.particles().over({}),
                                        options.over(portrait_settings()), threads)
                             .file;
    if (options.view().transparent(false)) leave_out_ground(portrait.scene);
    remove_more_duplicates(portrait, threads);
    return portrait;
  }
  options.particles().check_unused(file);
  SceneFile scene = read_scene_file(file, threads);
  if (named == NamedFiles::beside) check_beside(scene, file);
  if (change.particles) choose_frame(scene, *change.particles, file);
  if (!scene.particles.empty()) {
    expand_particles(scene, file, threads);
    remove_more_duplicates(scene, threads);
  }
  scene.settings = options.over(scene.settings);
  return scene;
}

}  // namespace

SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change, NamedFiles named) {
  SceneFile scene = read_any(file, options, change, named, usable_cpus());
  scene.transparent = options.view().transparent(scene.transparent);
  if (change.camera) scene.scene.camera = *change.camera;
  warn_of_duplicates(scene.duplicates, file);
  return scene;
}

}  // namespace parray
