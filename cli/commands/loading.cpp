#include "cli/commands/loading.h"

#include "cli/commands/printing.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/particles/expand.h"
#include "common/input/particles/portrait_scene.h"

namespace parray {
namespace {

void choose_frame(SceneFile& scene, std::uint64_t frame, const std::string& file) {
  bool chosen = false;
  for (ParticleSource& source : scene.particles) {
    if (!source.frame && may_hold_frames(source.file)) {
      source.frame = frame;
      chosen = true;
    }
  }
  if (!chosen) {
    throw InputError(printable(file, 4096) +
                     ": nothing in it changes from frame to frame: write #### for the number in "
                     "the scene's name, add --camera-path, or let the scene have a trajectory");
  }
}

SceneFile read_any(const std::string& file, const RenderOptions& options,
                   const FrameChange& change) {
  if (is_particle_file(file)) {
    return portrait_scene(file, {}, {}, options.over(portrait_settings()), usable_cpus()).file;
  }
  SceneFile scene = read_scene_file(file);
  if (change.particles) choose_frame(scene, *change.particles, file);
  expand_particles(scene, file, usable_cpus());
  scene.settings = options.over(scene.settings);
  return scene;
}

}  // namespace

SceneFile load_scene(const std::string& file, const RenderOptions& options,
                     const FrameChange& change) {
  SceneFile scene = read_any(file, options, change);
  if (change.camera) scene.scene.camera = *change.camera;
  // Reading has looked at the spheres of the file itself; now its particles are among them.
  const Duplicates more = remove_duplicates(scene.scene, usable_cpus());
  if (scene.duplicates.count == 0) {
    scene.duplicates = more;
  } else {
    scene.duplicates.count += more.count;
  }
  warn_of_duplicates(scene.duplicates, file);
  return scene;
}

}  // namespace parray
