#include "cli/input/view/auto_scene.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/view/principal_axes.h"
#include "common/base/error.h"
#include "common/scene/settings.h"

namespace parray::input {
namespace {

/// Returns the eight corners of the cell.
std::vector<Vec3d> corners_of(const ParticleCell& cell) {
  std::vector<Vec3d> corners{cell.origin};
  for (const Vec3d& edge : cell.edges) {
    const std::size_t before = corners.size();
    for (std::size_t i = 0; i < before; ++i) corners.push_back(corners[i] + edge);
  }
  return corners;
}

/// Returns whether particles extend over at least three quarters of each edge. Boxes of simulations
/// are filled. The cell of a crystal is usually not filled before its symmetry is applied.
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

Subject subject_of(const SelectedParticles& selected, const Viewing& viewing) {
  const Particles& particles = selected.particles;
  Subject subject;
  const auto& cell = particles.cell;
  subject.molecule =
      !particles.elements.empty() &&
      (!cell || (!particles.residue_names.empty() && !is_filled(*cell, particles.positions)));
  if (cell && (viewing.whole_cell || selected.crystal)) subject.corners = corners_of(*cell);
  return subject;
}

AutoScene made(PackedFile& file, ParticleSource source, const RenderSettings& settings,
               const Viewing& viewing, int threads) {
  SelectedParticles selected = selected_particles(file, source, {}, threads);
  AutoScene out;
  source.file = file.name();
  out.file.settings = settings;
  out.file.postprocessing = postprocessing_of(viewing.style);
  Scene& scene = out.file.scene;
  for (const SceneryObject& object : scenery_of(viewing)) {
    out.file.materials.define(std::string(object.name), object.material);
    scene.materials.push_back(object.material);
  }
  const auto scenery = static_cast<std::uint32_t>(scene.materials.size());
  out.file.scenery = scenery;
  scene.spheres.resize(scenery);
  const bool radius_is_open =
      decided(source.look.radius, selected.particles).rule == ParticleRadius::Rule::automatic;
  if (selected.crystal) {
    source.cell.crystal = true;
    out.file.labels.cell = out.file.cell_if_it_fits = true;
  }
  const Subject subject = subject_of(selected, viewing);
  const DefaultLook look{std::string(plain_material_name), plain_material, 1};
  out.source = append_selected(std::move(selected), file.path(), std::move(source), out.file,
                               threads, &look);
  const auto spheres = std::span(scene.spheres).subspan(scenery);
  if (radius_is_open) {
    out.source.look.radius.value = lattice_radius(spheres);
    for (Sphere& sphere : spheres) sphere.radius = out.source.look.radius.value;
  }
  try {
    const double aspect = static_cast<double>(settings.width) / settings.height;
    const Surroundings around = surroundings_of(spheres, aspect, viewing, subject, threads);
    scene.camera = around.camera;
    scene.sky = around.sky;
    for (std::uint32_t i = 0; i < scenery; ++i) {
      scene.spheres[i] = around.scenery[i].sphere;
      scene.spheres[i].material = i;
    }
  } catch (const InputError& error) {
    FilePlace{file.name()}.fail(error.what());
  }
  return out;
}

}  // namespace

Boxed<RenderSettings> auto_scene_settings() {
  RenderSettings settings;
  settings.width = 1200;
  settings.height = 900;
  settings.samples_per_pixel = 256;
  return settings;
}

AutoScene auto_scene(const std::filesystem::path& path, ParticleSource source,
                     const RenderSettings& settings, const Viewing& viewing, int threads) {
  PackedFile file(path);
  return auto_scene(file, std::move(source), settings, viewing, threads);
}

AutoScene auto_scene(PackedFile& file, ParticleSource source, const RenderSettings& settings,
                     const Viewing& viewing, int threads) {
  const FilePlace place{file.name()};
  try {
    return made(file, std::move(source), settings, viewing, threads);
  } catch (const SourceError& error) {
    if (error.key() == "material" || error.key() == "radius") throw InputError(error.what());
    std::string option = error.key();
    std::ranges::replace(option, '_', '-');
    place.fail("--" + option + ": " + error.what());
  }
}

SceneFile with_reference(AutoScene scene, const std::string& file) {
  SceneFile out = std::move(scene.file);
  out.scene.spheres.resize(out.scenery);
  out.scene.materials.resize(out.scenery);
  out.particles = {std::move(scene.source)};
  out.particles.front().file = file;
  return out;
}

}  // namespace parray::input
