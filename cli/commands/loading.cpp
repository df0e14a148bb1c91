#include "cli/commands/loading.h"

#include "common/particles/expand.h"
#include "common/particles/portrait_scene.h"

namespace parray {

SceneFile load_scene(const std::string& file, const RenderOptions& options) {
  if (is_particle_file(file)) {
    return portrait_scene(file, {}, {}, options.over(portrait_settings())).file;
  }
  SceneFile scene = read_scene_file(file);
  expand_particles(scene, file);
  scene.settings = options.over(scene.settings);
  return scene;
}

}  // namespace parray
