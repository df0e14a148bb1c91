#pragma once

#include <span>

#include "common/scene/scene.h"

namespace parray::input {

/// A right-handed frame: right x up = back.
struct Axes {
  Vec3d right, up, back;  ///< orthogonal unit vectors
  Vec3d center;
};

/// Returns the frame around the mean of the spheres' centres in which they spread most along
/// `right` and least along `back`. `spheres` is not empty.
///
/// Computes the eigenvectors of the covariance matrix by cyclic Jacobi rotations (Golub and Van
/// Loan, Matrix Computations, 8.5). It uses only + - * / sqrt, so all machines agree. Scaling all
/// centres by a power of two scales `center` and changes nothing else. If spreads are nearly equal
/// and `leaning` is true, the frame prefers the coordinate axes: x right, y up, z back. The largest
/// component of `up` and of `back` is positive.
Axes principal_axes(std::span<const Sphere> spheres, bool leaning = true);

/// Returns a radius for centres without radii. It is half the spacing of a cubic lattice in a box,
/// a sheet or a line with the same number of points and the same spread, at least
/// limits::min_radius. Returns 1 if all centres are equal. Rotating the centres changes the radius
/// only by rounding. Scaling the centres scales it. `spheres` is not empty.
double lattice_radius(std::span<const Sphere> spheres);

}  // namespace parray::input
