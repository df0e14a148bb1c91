#include "cli/input/particles/cell.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "cli/input/particles/stated_bonds.h"
#include "cli/input/select/neighbour_grid.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Returns the cosine of an angle in degrees, and exactly 0 for a right angle despite the rounding
/// of pi.
double cosine_of(double degrees) {
  return degrees == 90 ? 0 : std::cos(degrees * std::numbers::pi / 180);
}

bool is_length(double length) { return length > 0 && length <= limits::max_length; }
bool is_angle(double degrees) { return degrees > 0 && degrees < 180; }

/// Returns the vector of f(0), f(1), f(2).
Vec3d by_axis(const auto& f) { return {f(0), f(1), f(2)}; }

Vec3d as_vector(const CellImage& image) {
  return by_axis([&](std::size_t i) { return static_cast<double>(image[i]); });
}

/// Rounds a number to an integer. Numbers beyond 2^62, where positions have no fraction, become 0.
std::int64_t as_integer(double number) {
  constexpr double most = 0x1p62;
  return std::abs(number) < most ? static_cast<std::int64_t>(number) : 0;
}

/// Returns the circular mean of the fractions along an axis. Returns 0 if they have none.
double circular_mean(const CellFractions& fractions, const Particles& particles,
                     const ParticleMask& mask, std::size_t axis) {
  double cosine = 0;
  double sine = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const double turn =
        2 * std::numbers::pi * component(fractions.of(particles.positions[i]), axis);
    cosine += std::cos(turn);
    sine += std::sin(turn);
  }
  return std::atan2(sine, cosine) / (2 * std::numbers::pi);
}

/// Returns the bonds of all copies of the particles. Copies follow each other along a, then b, then
/// c. A bond leads to the copy in whose place the nearest image of its particle is.
std::vector<StatedBond> replicated_bonds(const Particles& particles, const CellFractions& fractions,
                                         const Replicas& replicas) {
  const auto& [a, b, c] = replicas.counts;
  const auto first_of = [&](const CellImage& copy) {
    std::uint64_t place = 0;
    for (std::size_t axis = copy.size(); axis-- > 0;) {
      const std::int64_t count = replicas.counts[axis];
      place = place * replicas.counts[axis] +
              static_cast<std::uint64_t>(((copy[axis] % count) + count) % count);
    }
    return place * particles.count();
  };
  std::vector<StatedBond> bonds;
  bonds.reserve(particles.bonds.size() * a * b * c);
  for (const StatedBond& bond : particles.bonds) {
    const auto [x, y, z] =
        fractions.nearest(particles.positions[bond.first], particles.positions[bond.second]);
    for (std::int64_t k = 0; k < c; ++k) {
      for (std::int64_t j = 0; j < b; ++j) {
        for (std::int64_t i = 0; i < a; ++i) {
          bonds.push_back(bond_between(first_of({i, j, k}) + bond.first,
                                       first_of({i + x, j + y, k + z}) + bond.second));
        }
      }
    }
  }
  put_in_order(bonds);
  return bonds;
}

/// Returns the product of the counts. Returns nothing if it is more than `most`.
std::optional<std::uint64_t> product_of(const Replicas& replicas, std::uint64_t most) {
  std::uint64_t product = 1;
  for (const std::uint32_t count : replicas.counts) {
    if (count > most / product) return {};
    product *= count;
  }
  return product;
}

/// Returns the step along an edge from a particle to its copy on the opposite face. Returns 0 for a
/// particle that is on neither face.
std::int64_t step_to_copy(double fraction, double tolerance) {
  if (std::abs(fraction) <= tolerance) return 1;
  return std::abs(fraction - 1) <= tolerance ? -1 : 0;
}

/// Returns the images of a particle with these fractions on opposite faces. Returns none for a
/// particle outside the cell.
std::vector<CellImage> boundary_images(const Vec3d& fractions, const Vec3d& tolerance,
                                       const std::array<bool, 3>& periodic) {
  std::vector<CellImage> images;
  for (std::size_t axis = 0; axis < periodic.size(); ++axis) {
    const double fraction = component(fractions, axis);
    const double slack = component(tolerance, axis);
    if (!periodic[axis]) continue;
    if (fraction < -slack || fraction > 1 + slack) return {};
    const std::int64_t step = step_to_copy(fraction, slack);
    if (step == 0) continue;
    const std::size_t known = images.size();
    images.push_back({});
    images.back()[axis] = step;
    for (std::size_t i = 0; i < known; ++i) {
      images.push_back(images[i]);
      images.back()[axis] = step;
    }
  }
  return images;
}

}  // namespace

std::optional<ParticleCell> cell_from(const Vec3d& lengths, const Vec3d& angles) {
  if (!is_length(lengths.x) || !is_length(lengths.y) || !is_length(lengths.z)) return {};
  if (!is_angle(angles.x) || !is_angle(angles.y) || !is_angle(angles.z)) return {};
  const double alpha = cosine_of(angles.x);
  const double beta = cosine_of(angles.y);
  const double gamma = cosine_of(angles.z);
  const double sine = std::sqrt(1 - gamma * gamma);
  const double across = (alpha - beta * gamma) / sine;  // components of the unit vector along c
  const double up = std::sqrt(std::max(0.0, 1 - beta * beta - across * across));
  return valid_cell({{},
                     {Vec3d{lengths.x, 0, 0}, lengths.y * Vec3d{gamma, sine, 0},
                      lengths.z * Vec3d{beta, across, up}}});
}

std::optional<ParticleCell> valid_cell(const ParticleCell& cell) {
  const auto& [a, b, c] = cell.edges;
  const double volume = std::abs(dot(a, cross(b, c)));
  if (!(volume > 0) || !std::isfinite(volume + length(cell.origin))) return {};
  return cell;
}

CellFractions::CellFractions(const ParticleCell& cell) : cell_(cell) {
  const auto& [a, b, c] = cell.edges;
  const double volume = dot(a, cross(b, c));
  slopes_ = {(1 / volume) * cross(b, c), (1 / volume) * cross(c, a), (1 / volume) * cross(a, b)};
}

Vec3d CellFractions::of(const Vec3d& position) const {
  return by_axis([&](std::size_t i) { return dot(position - cell_.origin, slopes_[i]); });
}

Vec3d CellFractions::translation(const Vec3d& fractions) const {
  return fractions.x * cell_.edges[0] + fractions.y * cell_.edges[1] + fractions.z * cell_.edges[2];
}

Vec3d CellFractions::translation(const CellImage& image) const {
  return translation(as_vector(image));
}

Vec3d CellFractions::heights() const {
  return by_axis([&](std::size_t i) { return 1 / length(slopes_[i]); });
}

CellImage CellFractions::image_of(const Vec3d& fractions) const {
  constexpr double rounding = 1e-6;
  CellImage image{};
  for (std::size_t i = 0; i < image.size(); ++i) {
    if (cell_.periodic[i]) image[i] = as_integer(std::floor(component(fractions, i) + rounding));
  }
  return image;
}

CellImage CellFractions::nearest(const Vec3d& from, const Vec3d& to) const {
  const Vec3d fractions = of(from) - of(to);
  CellImage rounded{};
  for (std::size_t i = 0; i < rounded.size(); ++i) {
    if (cell_.periodic[i]) rounded[i] = as_integer(std::round(component(fractions, i)));
  }
  CellImage best = rounded;  // in an oblique cell, a neighbour of the rounded image may be nearer
  double least = length(to + translation(best) - from);
  for (int n = 0; n < 27; ++n) {
    const CellImage step{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    CellImage image = rounded;
    for (std::size_t i = 0; i < image.size(); ++i) {
      if (cell_.periodic[i]) image[i] += step[i];
    }
    const double distance = length(to + translation(image) - from);
    if (distance < least * (1 - 1e-9)) {
      best = image;
      least = distance;
    }
  }
  return best;
}

Replicas replicas_from(std::string_view text) {
  const std::vector<std::string_view> parts = split_at('x', text);
  Replicas replicas;
  bool valid = parts.size() == replicas.counts.size();
  for (std::size_t i = 0; valid && i < parts.size(); ++i) {
    const std::optional<std::uint64_t> count = natural_in(parts[i]);
    valid = count && *count > 0 && *count <= limits::max_shapes;
    if (valid) replicas.counts[i] = static_cast<std::uint32_t>(*count);
  }
  if (valid) return replicas;
  throw InputError("'" + printable(text) +
                   "' is not a number of copies: write three whole numbers from 1 to " +
                   std::to_string(limits::max_shapes) + ", such as 3x3x2");
}

std::string text_of(const Replicas& replicas) {
  if (!replicas.any()) return {};
  const auto& [a, b, c] = replicas.counts;
  return std::to_string(a) + "x" + std::to_string(b) + "x" + std::to_string(c);
}

void replicate(Particles& particles, const Replicas& replicas) {
  const std::optional<std::uint64_t> copies =
      product_of(replicas, limits::max_shapes / particles.count());
  if (!copies) {
    throw InputError(text_of(replicas) + " copies of " + std::to_string(particles.count()) +
                     " particles are more than " + std::to_string(limits::max_shapes) +
                     " spheres: use fewer copies");
  }
  ParticleCell& cell = *particles.cell;
  const CellFractions fractions(cell);
  const std::size_t count = particles.count();
  particles.bonds = replicated_bonds(particles, fractions, replicas);
  repeat(particles, *copies);
  std::size_t to = 0;
  CellImage image{};
  for (image[2] = 0; image[2] < replicas.counts[2]; ++image[2]) {
    for (image[1] = 0; image[1] < replicas.counts[1]; ++image[1]) {
      for (image[0] = 0; image[0] < replicas.counts[0]; ++image[0]) {
        const Vec3d step = fractions.translation(image);
        for (std::size_t i = 0; i < count; ++i, ++to) {
          particles.positions[to] = particles.positions[i] + step;
        }
      }
    }
  }
  for (std::size_t i = 0; i < cell.edges.size(); ++i) {
    cell.edges[i] = static_cast<double>(replicas.counts[i]) * cell.edges[i];
  }
}

std::uint64_t add_boundary_copies(Particles& particles, const Vec3d& tolerance) {
  const ParticleCell& cell = *particles.cell;
  const CellFractions fractions(cell);
  std::vector<Vec3d> beside_faces;  // where a copy could meet a particle
  std::vector<std::size_t> sources;
  std::vector<Vec3d> copies;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const Vec3d& position = particles.positions[i];
    const Vec3d fraction = fractions.of(position);
    if (boundary_images(fraction, 4 * tolerance, cell.periodic).empty()) continue;
    beside_faces.push_back(position);
    for (const CellImage& image : boundary_images(fraction, tolerance, cell.periodic)) {
      sources.push_back(i);
      copies.push_back(position + fractions.translation(image));
    }
  }
  const Vec3d reach =
      by_axis([&](std::size_t i) { return component(tolerance, i) * length(cell.edges[i]); });
  const NeighbourGrid present(beside_faces, 2 * std::max({reach.x, reach.y, reach.z}));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (present.near(copies[i])) continue;
    sources[kept] = sources[i];
    copies[kept++] = copies[i];
  }
  sources.resize(kept);
  copies.resize(kept);
  append_copies(particles, sources);
  std::ranges::copy(copies, particles.positions.end() - static_cast<std::ptrdiff_t>(kept));
  return kept;
}

void wrap(Particles& particles, std::span<const std::uint32_t> molecule) {
  const CellFractions fractions(*particles.cell);
  std::vector<Vec3d>& positions = particles.positions;
  if (molecule.empty()) {
    for (Vec3d& p : positions) p = p - fractions.translation(fractions.image_of(fractions.of(p)));
    return;
  }
  std::vector<Vec3d> steps(std::ranges::max(molecule) + std::size_t{1});
  std::vector<double> counts(steps.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {  // sums, then translations
    steps[molecule[i]] = steps[molecule[i]] + fractions.of(positions[i]);
    ++counts[molecule[i]];
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (counts[i] > 0) {
      steps[i] = fractions.translation(fractions.image_of((1 / counts[i]) * steps[i]));
    }
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = positions[i] - steps[molecule[i]];
  }
}

void center_on(Particles& particles, const ParticleMask& mask) {
  const ParticleCell& cell = *particles.cell;
  const CellFractions fractions(cell);
  const Vec3d center = by_axis([&](std::size_t axis) {
    const double mean = cell.periodic[axis] ? circular_mean(fractions, particles, mask, axis) : 0;
    double sum = 0;
    double count = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      if (mask[i] == 0) continue;
      const double from_mean = component(fractions.of(particles.positions[i]), axis) - mean;
      sum += cell.periodic[axis] ? from_mean - std::round(from_mean) : from_mean;
      ++count;
    }
    return mean + sum / count;
  });
  const Vec3d step = fractions.translation(Vec3d{0.5, 0.5, 0.5} - center);
  for (Vec3d& position : particles.positions) position = position + step;
}

}  // namespace parray::input
