#pragma once

#include <span>

#include "common/scene/scene.h"

namespace parray {

/// A picture of some spheres as a paper would print it: seen from where they show most, a little
/// from above and aside, through a long lens, standing on a pale floor that fills the background.
/// An even sky lights them but for a flag, as photographers call it: a black sphere outside the
/// picture that keeps the light off one side. So light comes from the upper left of the picture,
/// whatever directions the coordinates have.
struct Portrait {
  Camera camera;  ///< a pinhole; tan_half_vfov is set
  Sky sky;
  Sphere ground;  ///< touches the lowest sphere from below
  Sphere flag;    ///< `material` of both is not set
};

inline constexpr Material portrait_ground{MaterialType::diffuse, {0.75, 0.75, 0.75}, 0, 1};
inline constexpr Material portrait_flag{MaterialType::diffuse, {0, 0, 0}, 0, 1};
/// Of particles of which no more is known than where they are.
inline constexpr Material portrait_plain{MaterialType::diffuse, {0.35, 0.48, 0.65}, 0, 1};

/// The portrait of `spheres`, which are not empty, for a picture `aspect` times as wide as high
/// (> 0). Largest principal axis to the right, smallest towards the viewer; every sphere is inside
/// the view, and they fill it but for a margin. Scaling spheres by a power of two scales the
/// portrait exactly, but for rounding at the ends of double's range.
///
/// Throws InputError, without a file's name, when camera or ground would lie beyond
/// limits::max_length, or the group is so far from the origin that the digits do not tell the
/// camera's place from what it looks at.
Portrait portrait_of(std::span<const Sphere> spheres, double aspect, int threads = 1);

}  // namespace parray
