#include "common/input/portrait/portrait_scene.h"

#include <span>
#include <string>
#include <utility>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/particles/expand.h"
#include "common/input/particles/particle_spheres.h"
#include "common/input/portrait/portrait.h"
#include "common/input/portrait/principal_axes.h"

namespace parray {
namespace {

constexpr std::uint32_t helpers = 2;  ///< ground and flag, the first spheres and materials

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& problem) {
  throw InputError(printable(path.string(), 4096) + ": " + problem);
}

void check(const std::string& problem) {
  if (!problem.empty()) throw InputError(problem);
}

/// Decides the rules; true when the radius is left to lattice_radius().
bool decide(ParticleSource& source, const Particles& particles, MaterialNames& materials) {
  source.material = decided(source.material, particles);
  if (source.material.rule == ParticleMaterial::Rule::automatic) {
    source.material = particle_material_from(portrait_plain_name);
  }
  if (text_of(source.material) == portrait_plain_name) {
    materials.define(std::string(portrait_plain_name), portrait_plain);
  }
  check(problem_with(source.material, particles, materials, source.file, portrait_plain_name));
  source.radius = decided(source.radius, particles);
  if (source.radius.rule == ParticleRadius::Rule::automatic) return true;
  check(problem_with(source.radius, particles, source.file));
  return false;
}

}  // namespace

RenderSettings portrait_settings() {
  RenderSettings settings;
  settings.width = 1200;
  settings.height = 900;
  settings.samples_per_pixel = 256;
  return settings;
}

PortraitScene portrait_scene(const std::filesystem::path& path, ParticleSource source,
                             const RenderSettings& settings, int threads) {
  Particles particles = read_particles(path, {.frame = source.frame, .threads = threads});
  PortraitScene out;
  out.source = std::move(source);
  out.source.file = path.string();
  out.file.settings = settings;
  MaterialNames& names = out.file.materials;
  names.define("ground", portrait_ground);
  names.define("flag", portrait_flag);
  const bool radius_is_open = decide(out.source, particles, names);
  if (radius_is_open) out.source.radius = {ParticleRadius::Rule::fixed, 1};
  Scene& scene = out.file.scene;
  scene.materials = {portrait_ground, portrait_flag};
  scene.spheres.resize(helpers);
  note_particles(out.file, particles);
  out.file.staging = helpers;
  add_legend(out.file.legends, legend_of(particles, out.source.material, names));
  append_spheres(std::move(particles), out.source, names, scene, threads);
  const auto shown = std::span(scene.spheres).subspan(helpers);
  if (radius_is_open) {
    out.source.radius.value = lattice_radius(shown);
    for (Sphere& sphere : shown) sphere.radius = out.source.radius.value;
  }
  try {
    const Portrait portrait =
        portrait_of(shown, static_cast<double>(settings.width) / settings.height, threads);
    scene.camera = portrait.camera;
    scene.sky = portrait.sky;
    scene.spheres[0] = portrait.ground;
    scene.spheres[1] = portrait.flag;
    scene.spheres[1].material = 1;
  } catch (const InputError& error) {
    fail(path, error.what());
  }
  return out;
}

void leave_out_ground(Scene& scene) {
  scene.spheres.erase(scene.spheres.begin());  // others may have its material
}

SceneFile with_reference(PortraitScene portrait, const std::string& file) {
  SceneFile out = std::move(portrait.file);
  out.scene.spheres.resize(helpers);
  out.scene.materials.resize(helpers);
  out.particles = {std::move(portrait.source)};
  out.particles.front().file = file;
  return out;
}

}  // namespace parray
