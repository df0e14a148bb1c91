#pragma once

#include <span>

#include "common/scene/scene.h"

namespace parray::input {

/// A right-handed frame: right x up = back.
struct Axes {
  Vec3d right, up, back;  ///< unit vectors at right angles
  Vec3d center;
};

/// The frame in which spheres' centres spread most along `right` and least along `back`, around
/// their mean. `spheres` is not empty.
///
/// The eigenvectors of the covariance matrix by cyclic Jacobi rotations (Golub and Van Loan, Matrix
/// Computations, 8.5) in + - * / sqrt alone, so the same on every machine. Scaling all centres by a
/// power of two scales `center` and changes nothing else.
/// Where spreads are nearly equal the frame, if it is `leaning`, leans to the coordinate axes: x
/// right, y up, z back. Of the two signs of `up` and of `back`, the largest component is positive.
Axes principal_axes(std::span<const Sphere> spheres, bool leaning = true);

/// A radius for centres that come without: half the spacing of the cubic lattice in a box, a sheet
/// or a line that has as many points and spreads as much. 1 where all centres are one. Turning
/// them changes nothing but rounding, scaling scales. `spheres` is not empty.
double lattice_radius(std::span<const Sphere> spheres);

}  // namespace parray::input
