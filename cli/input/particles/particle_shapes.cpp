#include "cli/input/particles/particle_shapes.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "cli/input/particles/arrows.h"
#include "cli/input/particles/file_place.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

bool is_inside(const Vec3d& p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= limits::max_length;
}

}  // namespace

ParticleShapes::ParticleShapes(const SelectedParticles& selected, const ParticleSource& source,
                               Scene& scene)
    : selected_(selected), source_(source), scene_(scene), first_(scene.spheres.size()) {
  if (!selected.bonds.empty() || !selected.arrows.arrows.empty()) particles_.resize(selected.count);
}

void ParticleShapes::add_part(const SelectedPart& part) {
  const auto spheres = std::span(scene_.spheres).subspan(first_);
  const double stick_radius = part.look.stick_radius.value_or(selected_.stick_radius);
  shape_spheres(part.look, stick_radius, spheres);
  if (!particles_.empty()) {
    const bool sticks = has_sticks(part.look.style);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      particles_[part.numbers.empty() ? i : part.numbers[i]] = {
          static_cast<std::uint32_t>(first_ + i), sticks ? stick_radius : 0, true};
    }
  }
  first_ = scene_.spheres.size();
}

void ParticleShapes::append_capsules() {
  const std::size_t first = scene_.capsules.size();
  append_sticks(selected_.bonds, particles_, scene_);
  append_arrows();
  if (source_.solid_cell) append_edges();
  check_limits(first);
}

void ParticleShapes::append_arrows() {
  const ParticleArrows& arrows = selected_.arrows;
  for (std::size_t i = 0; i < arrows.arrows.size(); ++i) {
    if (!particles_[i].shown) continue;
    const Sphere& sphere = scene_.spheres[particles_[i].sphere];
    append_arrow(sphere.center, arrows.arrows[i], arrows.width, sphere.material, scene_.capsules);
  }
}

void ParticleShapes::append_edges() {
  if (!selected_.cell) {
    throw SourceError("solid_cell", "the file has no box and no cell: leave it out");
  }
  const auto known = std::ranges::find(scene_.materials, cell_material);
  const auto material = static_cast<std::uint32_t>(known - scene_.materials.begin());
  if (known == scene_.materials.end()) scene_.materials.push_back(cell_material);
  append_cell(*selected_.cell, material, scene_.capsules);
}

void ParticleShapes::check_limits(std::size_t first_capsule) const {
  const auto fail = [&](const std::string& problem) {
    throw InputError(printable(source_.file, 4096) + ": " + problem);
  };
  if (scene_.spheres.size() + scene_.capsules.size() > limits::max_shapes) {
    fail("more than " + std::to_string(limits::max_shapes) +
         " spheres and capsules in all: split the scene");
  }
  for (const Capsule& capsule : std::span(scene_.capsules).subspan(first_capsule)) {
    if (!is_inside(capsule.from) || !is_inside(capsule.to)) {
      fail(
          "a bond, an arrow or an edge of the cell would reach beyond 1e15: use a larger unit of "
          "length in the file, or shorter arrows");
    }
  }
}

}  // namespace parray::input
