#include "cli/input/particles/cell.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace parray::input
