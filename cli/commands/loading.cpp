#include "cli/commands/loading.h"

#include "cli/commands/printing.h"
#include "common/input/particles/expand.h"
#include "common/input/particles/portrait_scene.h"

namespace parray {
namespace {

SceneFile read_any(const std::string& file, const RenderOptions& options) {
  if (is_particle_file(file)) {
    return portrait_scene(file, {}, {}, options.over(portrait_settings())).file;
  }
  SceneFile scene = read_scene_file(file);
  expand_particles(scene, file);
  scene.settings = options.over(scene.settings);
  return scene;
}

}  // namespace

SceneFile load_scene(const std::string& file, const RenderOptions& options) {
  SceneFile scene = read_any(file, options);
  // Reading has looked at the spheres of the file itself; now its particles are among them.
  const Duplicates more = remove_duplicates(scene.scene);
  if (scene.duplicates.count == 0) {
    scene.duplicates = more;
  } else {
    scene.duplicates.count += more.count;
  }
  warn_of_duplicates(scene.duplicates, file);
  return scene;
}

}  // namespace parray
