#include <algorithm>
#include <array>
#include <cmath>

#include "cli/input/view/view.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Vec3d mean_center(std::span<const Sphere> spheres) {
  // Uses differences from the first centre, which are precise even far from the origin.
  const Vec3d first = spheres.front().center;
  Vec3d sum;
  for (const Sphere& sphere : spheres) sum = sum + (sphere.center - first);
  return first + (1 / static_cast<double>(spheres.size())) * sum;
}

Matrix covariance_of(std::span<const Sphere> spheres, const Vec3d& mean) {
  Matrix sum{};
  for (const Sphere& sphere : spheres) {
    const Vec3d v = sphere.center - mean;
    const std::array<double, 3> d{v.x, v.y, v.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j) sum[i][j] += d[i] * d[j];
    }
  }
  for (auto& row : sum) {
    for (double& x : row) x /= static_cast<double>(spheres.size());
  }
  return sum;
}

/// Gives each axis a little more spread than the next. A cubic lattice has equal spread in all
/// directions except for noise. Without this bias, the noise would determine its orientation.
void lean_to_coordinate_axes(Matrix& covariance) {
  constexpr double lean =
      0.03;  // share of the total spread; the noise of 10 000 random centres is 0.01
  const double whole = covariance[0][0] + covariance[1][1] + covariance[2][2];
  covariance[0][0] += lean * whole;
  covariance[1][1] += lean / 2 * whole;
}

/// Rotates rows and columns p < q of the symmetric matrix `a` so that a[p][q] becomes 0. Rotates
/// the columns of `vectors` as well. Uses only the upper triangle.
void rotate(Matrix& a, Matrix& vectors, std::size_t p, std::size_t q) {
  if (a[p][q] == 0) return;
  const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + square_root(theta * theta + 1));
  const double c = 1 / square_root(t * t + 1);
  const double s = t * c;
  a[p][p] -= t * a[p][q];
  a[q][q] += t * a[p][q];
  a[p][q] = 0;
  const std::size_t r = 3 - p - q;  // the third index
  double& rp = a[std::min(r, p)][std::max(r, p)];
  double& rq = a[std::min(r, q)][std::max(r, q)];
  const double old = rp;
  rp = c * old - s * rq;
  rq = s * old + c * rq;
  for (auto& row : vectors) {
    const double at_p = row[p];
    row[p] = c * at_p - s * row[q];
    row[q] = s * at_p + c * row[q];
  }
}

Vec3d with_largest_component_positive(const Vec3d& v) {
  double largest = v.x;
  if (std::abs(v.y) > std::abs(largest)) largest = v.y;
  if (std::abs(v.z) > std::abs(largest)) largest = v.z;
  return largest < 0 ? -v : v;
}

/// Returns the v for which the increasing polynomial 1 + v + a v^2 + b v^3 (a, b >= 0) equals
/// `target` > 1.
double solve(double a, double b, double target) {
  double low = 0;
  double high = target - 1;
  for (int i = 0; i < 128; ++i) {
    const double v = (low + high) / 2;
    (1 + v * (1 + v * (a + v * b)) < target ? low : high) = v;
  }
  return high;
}

}  // namespace

Axes principal_axes(std::span<const Sphere> spheres, bool leaning) {
  const Vec3d center = mean_center(spheres);
  Matrix a = covariance_of(spheres, center);
  if (leaning) lean_to_coordinate_axes(a);
  Matrix vectors{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  constexpr int sweeps = 10;  // convergence is quadratic: five sweeps suffice
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    rotate(a, vectors, 0, 1);
    rotate(a, vectors, 0, 2);
    rotate(a, vectors, 1, 2);
  }
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
  const auto axis = [&](std::size_t i) {
    const std::size_t column = order[i];
    return with_largest_component_positive(
        {vectors[0][column], vectors[1][column], vectors[2][column]});
  };
  Axes frame;
  frame.center = center;
  frame.back = normalize(axis(2));
  frame.right = normalize(cross(axis(1), frame.back));  // orthogonal to the last digit
  frame.up = cross(frame.back, frame.right);
  return frame;
}

double lattice_radius(std::span<const Sphere> spheres) {
  const Matrix c = covariance_of(spheres, mean_center(spheres));
  const double trace = c[0][0] + c[1][1] + c[2][2];
  if (!(trace > 0)) return 1;
  const double minors = c[0][0] * c[1][1] - c[0][1] * c[0][1] + c[0][0] * c[2][2] -
                        c[0][2] * c[0][2] + c[1][1] * c[2][2] - c[1][2] * c[1][2];
  const double determinant = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[1][2]) -
                             c[0][1] * (c[0][1] * c[2][2] - c[1][2] * c[0][2]) +
                             c[0][2] * (c[0][1] * c[1][2] - c[1][1] * c[0][2]);
  // n points in steps of s on a line have the variance s^2 (n^2 - 1) / 12. So the number of points
  // of a lattice is the product of sqrt(12 variance / s^2 + 1) over its axes. The square of that
  // product is the determinant of 12 covariance / s^2 + 1. The code solves it for v = 12 trace /
  // s^2.
  const double count = static_cast<double>(spheres.size());
  const double v = solve(std::max(0.0, minors / (trace * trace)),
                         std::max(0.0, determinant / (trace * trace * trace)), count * count);
  return std::max(limits::min_radius, square_root(12 * trace / v) / 2);
}

}  // namespace parray::input
