#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cli/input/view/style.h"
#include "cli/input/view/view.h"
#include "common/scene/scene.h"

namespace parray::input {

/// How somebody wants portraits to be taken.
struct Viewing {
  View view = View::automatic;
  Style style = Style::studio;
  /// Not given: orthographic, but of the automatic view perspective.
  std::optional<Projection> projection{};
  bool transparent = false;  ///< no floor and no wall
  bool whole_cell = false;   ///< the particles' cell is to be in the picture, too
};

/// What a portrait is of, beside spheres.
struct Subject {
  bool molecule = true;          ///< see viewpoint_of()
  std::vector<Vec3d> corners{};  ///< points that are to be in the picture, too
};

/// A sphere that stands around a portrait's particles.
struct Prop {
  std::string_view name;  ///< of its material: "ground", "wall" or "flag"
  Material material;
  Sphere sphere{};  ///< `material` is not set
};

/// Those of portraits that are taken in that way, in their order; the spheres are not placed yet.
std::vector<Prop> props_of(const Viewing& viewing);

/// A picture of some spheres as a paper would print it: seen from where they show most, or from
/// where one asks for, through a long lens, every sphere inside the picture.
///
/// - ground: a pale floor under the lowest sphere or, of a view that does not look down on it, the
///   same behind the farthest. It fills the background.
/// - wall: a dark one behind all, so far away that their shadows do not reach it, and large enough
///   to fill the background.
/// - flag, as photographers call it: a black sphere outside the picture that keeps the sky's light
///   off one side. So light comes from the upper left of the picture, whatever directions the
///   coordinates have.
struct Portrait {
  Camera camera;  ///< a pinhole; tan_half_vfov is set
  Sky sky;
  std::vector<Prop> props;  ///< those of props_of()
};

/// Of particles of which no more is known than where they are.
inline constexpr Material portrait_plain{MaterialType::diffuse, {0.35, 0.48, 0.65}, 0, 1};

/// The portrait of `spheres`, which are not empty, for a picture `aspect` times as wide as high
/// (> 0). Every sphere is inside the view, and they fill it but for a margin. Scaling spheres by a
/// power of two scales the portrait exactly, but for rounding at the ends of double's range.
///
/// Throws InputError, without a file's name, when camera or props would lie beyond
/// limits::max_length, or the group is so far from the origin that the digits do not tell the
/// camera's place from what it looks at.
Portrait portrait_of(std::span<const Sphere> spheres, double aspect, const Viewing& viewing = {},
                     const Subject& subject = {}, int threads = 1);

}  // namespace parray::input
