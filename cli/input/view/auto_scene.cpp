#include "cli/input/view/auto_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/beads.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_spheres.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/particles/sticks.h"
#include "cli/input/view/view.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::input {
namespace {

/// Returns whether particles extend over at least three quarters of each edge. Boxes of simulations
/// are filled. The cell of a crystal is usually not filled before its symmetry is applied.
bool is_filled(const ParticleCell& cell, const std::vector<Vec3d>& positions) {
  constexpr double share = 0.75;
  const auto& [a, b, c] = cell.edges;
  const double volume = dot(a, cross(b, c));
  if (volume == 0) return true;
  for (const Vec3d& normal : {cross(b, c), cross(c, a), cross(a, b)}) {
    NumberBounds along;
    for (const Vec3d& position : positions) along.add(dot(position, normal));
    if (along.high - along.low < share * std::abs(volume)) return false;
  }
  return true;
}

Subject subject_of(const Particles& particles, bool with_cell) {
  Subject subject;
  const auto& cell = particles.cell;
  subject.molecule =
      !particles.elements.empty() &&
      (!cell || (!particles.residue_names.empty() && !is_filled(*cell, particles.positions)));
  if (cell && with_cell) subject.corners = corners_of(*cell);
  return subject;
}

/// The spheres of a part whose radius the file does not determine.
struct OpenRadius {
  std::size_t begin;
  std::size_t end;
  std::optional<std::size_t> representation;
  double share;  ///< of lattice_radius()
};

std::vector<OpenRadius> open_radii(const SelectedParticles& selected, bool crystal) {
  std::vector<OpenRadius> open;
  std::size_t begin = 0;
  for (const ParticlePart& part : selected.parts) {
    const std::size_t end = begin + part.particles.count();
    const ParticleStyle style = part.look.style;
    if (decided(part.look.radius, part.particles, crystal).rule ==
            ParticleRadius::Rule::automatic &&
        style != ParticleStyle::sticks) {
      const double share = style == ParticleStyle::balls_and_sticks ? 0.5 : 1;
      open.push_back({begin, end, part.representation, share});
    }
    begin = end;
  }
  return open;
}

/// Gives the radius lattice_radius() of all spheres to the parts that have none, and half of it to
/// balls between sticks.
void set_open_radii(const std::vector<OpenRadius>& open, std::span<Sphere> spheres,
                    ParticleSource& source) {
  if (open.empty()) return;
  const double lattice = lattice_radius(spheres);
  for (const OpenRadius& part : open) {
    const double radius = std::max(part.share * lattice, limits::min_radius);
    for (Sphere& sphere : spheres.subspan(part.begin, part.end - part.begin)) {
      sphere.radius = radius;
    }
    ParticleLook& look =
        part.representation ? source.shows[*part.representation].look : source.look;
    look.radius.value = radius;
  }
}

/// Returns the surroundings of the particles in `file`, and changes the camera of `file`. The
/// caller has set the settings, labels and shapes. A crystal has the cell as a label without being
/// asked. The function removes that label if the labels leave too little room.
Surroundings surroundings_in(SceneFile& file, const Viewing& viewing, Subject subject,
                             int threads) {
  subject.capsules = file.scene.capsules;
  if (viewing.labels) {
    subject.labels = [&](const Camera& camera) {
      file.scene.camera = camera;
      try {
        return viewing.labels(file);
      } catch (const InputError& error) {
        throw LabelError(error.what());
      }
    };
  }
  const auto around = [&] {
    const double aspect = static_cast<double>(file.settings->width) / file.settings->height;
    const auto spheres = std::span(file.scene.spheres).subspan(file.scenery);
    return surroundings_of(spheres, aspect, viewing, subject, threads);
  };
  try {
    return around();
  } catch (const LabelError&) {
    if (!file.cell_if_it_fits || viewing.whole_cell) throw;
  }
  file.labels.cell = file.cell_if_it_fits = false;
  return around();
}

AutoScene made(PackedFile& file, ParticleSource source, const RenderSettings& settings,
               const Viewing& viewing, int threads) {
  const ParticleRequest request = request_of(source, {}, threads);
  Particles all = read_particles(file, request);
  decide_for_beads(all, source);
  Particles particles = selected(std::move(all), file, source, request);
  const bool crystal = source.cell.crystal.value_or(false);
  decide_style(particles, source);
  const Subject subject = subject_of(particles, viewing.whole_cell || crystal || source.solid_cell);
  SelectedParticles parts = parts_of(std::move(particles), file, source, request);
  AutoScene out;
  source.file = file.name();
  out.file.labels.cell = out.file.cell_if_it_fits = crystal;
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
  const std::vector<OpenRadius> open = open_radii(parts, crystal);
  const DefaultLook look{std::string(plain_material_name), plain_material, 1};
  out.source =
      append_parts(std::move(parts), file.path(), std::move(source), out.file, threads, &look);
  set_open_radii(open, std::span(scene.spheres).subspan(scenery), out.source);
  try {
    const Surroundings around = surroundings_in(out.file, viewing, subject, threads);
    scene.camera = around.camera;
    scene.sky = around.sky;
    out.axis = around.axis;
    for (std::uint32_t i = 0; i < scenery; ++i) {
      scene.spheres[i] = around.scenery[i].sphere;
      scene.spheres[i].material = i;
    }
  } catch (const LabelError& error) {
    throw LabelError(printable(file.name(), 4096) + ": " + error.what());
  } catch (const InputError& error) {
    FilePlace{file.name()}.fail(error.what());
  }
  return out;
}

}  // namespace

std::vector<Vec3d> corners_of(const ParticleCell& cell) {
  std::vector<Vec3d> corners{cell.origin};
  for (const Vec3d& edge : cell.edges) {
    const std::size_t before = corners.size();
    for (std::size_t i = 0; i < before; ++i) corners.push_back(corners[i] + edge);
  }
  return corners;
}

Boxed<RenderSettings> auto_scene_settings() {
  RenderSettings settings;
  settings.width = 1200;
  settings.height = 900;
  settings.samples_per_pixel = 256;
  return settings;
}

AutoScene auto_scene(const std::filesystem::path& path, const ParticleSource& source,
                     const RenderSettings& settings, const Viewing& viewing, int threads) {
  PackedFile file(path);
  return auto_scene(file, source, settings, viewing, threads);
}

AutoScene auto_scene(PackedFile& file, const ParticleSource& source, const RenderSettings& settings,
                     const Viewing& viewing, int threads) {
  try {
    return made(file, source, settings, viewing, threads);
  } catch (const SourceError& error) {
    fail_in_options(error, source, file.name());
  }
}

SceneFile with_reference(AutoScene scene, const std::string& file) {
  SceneFile out = std::move(scene.file);
  out.scene.spheres.resize(out.scenery);
  out.scene.capsules.clear();
  out.scene.materials.resize(out.scenery);
  out.particles = {std::move(scene.source)};
  out.particles.front().file = file;
  return out;
}

}  // namespace parray::input
