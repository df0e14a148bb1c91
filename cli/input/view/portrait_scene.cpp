#include "cli/input/view/portrait_scene.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/shown_particles.h"
#include "cli/input/particles/source_error.h"
#include "cli/input/view/portrait.h"
#include "cli/input/view/principal_axes.h"
#include "common/base/error.h"

namespace parray::input {
namespace {

void check(const std::string& problem) {
  if (!problem.empty()) throw InputError(problem);
}

/// Decides the rules; true when the radius is left to lattice_radius().
bool decide(ParticleSource& source, const Particles& particles, MaterialNames& materials) {
  source.material = decided_material(source, particles);
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

/// The cell's corners.
std::vector<Vec3d> corners_of(const ParticleCell& cell) {
  std::vector<Vec3d> corners{cell.origin};
  for (const Vec3d& edge : cell.edges) {
    const std::size_t before = corners.size();
    for (std::size_t i = 0; i < before; ++i) corners.push_back(corners[i] + edge);
  }
  return corners;
}

/// Along each edge particles reach as far as three quarters of it: a box of a simulation. What is
/// in a crystal's cell but for its repetitions does not.
bool is_filled(const ParticleCell& cell, const std::vector<Vec3d>& positions) {
  constexpr double share = 0.75;
  const auto& [a, b, c] = cell.edges;
  const double volume = dot(a, cross(b, c));
  if (volume == 0) return true;
  for (const Vec3d& normal : {cross(b, c), cross(c, a), cross(a, b)}) {
    double low = dot(positions.front(), normal);
    double high = low;
    for (const Vec3d& position : positions) {
      low = std::min(low, dot(position, normal));
      high = std::max(high, dot(position, normal));
    }
    if (high - low < share * std::abs(volume)) return false;
  }
  return true;
}

Subject subject_of(const Particles& particles, const Viewing& viewing) {
  Subject subject;
  const auto& cell = particles.cell;
  subject.molecule =
      !particles.elements.empty() &&
      (!cell || (!particles.residue_names.empty() && !is_filled(*cell, particles.positions)));
  if (cell && viewing.whole_cell) subject.corners = corners_of(*cell);
  return subject;
}

PortraitScene taken(PackedFile& file, ParticleSource source, const RenderSettings& settings,
                    const Viewing& viewing, int threads) {
  ShownParticles shown = shown_particles(file, source, {}, threads);
  PortraitScene out;
  out.source = std::move(source);
  out.source.file = file.name();
  out.file.settings = settings;
  out.file.finish = finish_of(viewing.style);
  Scene& scene = out.file.scene;
  for (const Prop& prop : props_of(viewing)) {
    out.file.materials.define(std::string(prop.name), prop.material);
    scene.materials.push_back(prop.material);
  }
  const auto staging = static_cast<std::uint32_t>(scene.materials.size());
  out.file.staging = staging;
  scene.spheres.resize(staging);
  const bool radius_is_open = decide(out.source, shown.particles, out.file.materials);
  if (radius_is_open) out.source.radius = {ParticleRadius::Rule::fixed, 1};
  const Subject subject = subject_of(shown.particles, viewing);
  append_shown(std::move(shown), file.path(), out.source, out.file, threads);
  const auto spheres = std::span(scene.spheres).subspan(staging);
  if (radius_is_open) {
    out.source.radius.value = lattice_radius(spheres);
    for (Sphere& sphere : spheres) sphere.radius = out.source.radius.value;
  }
  try {
    const double aspect = static_cast<double>(settings.width) / settings.height;
    const Portrait portrait = portrait_of(spheres, aspect, viewing, subject, threads);
    scene.camera = portrait.camera;
    scene.sky = portrait.sky;
    for (std::uint32_t i = 0; i < staging; ++i) {
      scene.spheres[i] = portrait.props[i].sphere;
      scene.spheres[i].material = i;
    }
  } catch (const InputError& error) {
    FilePlace{file.name()}.fail(error.what());
  }
  return out;
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
                             const RenderSettings& settings, const Viewing& viewing, int threads) {
  PackedFile file(path);
  return portrait_scene(file, std::move(source), settings, viewing, threads);
}

PortraitScene portrait_scene(PackedFile& file, ParticleSource source,
                             const RenderSettings& settings, const Viewing& viewing, int threads) {
  const FilePlace place{file.name()};
  try {
    return taken(file, std::move(source), settings, viewing, threads);
  } catch (const SourceError& error) {
    std::string option = error.key();
    std::ranges::replace(option, '_', '-');
    place.fail("--" + option + ": " + error.what());
  }
}

SceneFile with_reference(PortraitScene portrait, const std::string& file) {
  SceneFile out = std::move(portrait.file);
  out.scene.spheres.resize(out.staging);
  out.scene.materials.resize(out.staging);
  out.particles = {std::move(portrait.source)};
  out.particles.front().file = file;
  return out;
}

}  // namespace parray::input
