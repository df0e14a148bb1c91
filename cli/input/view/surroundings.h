#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cli/input/view/style.h"
#include "cli/input/view/view.h"
#include "common/scene/scene.h"

namespace parray::input {

/// How an auto scene looks at its particles.
struct Viewing {
  View view = View::automatic;
  Style style = Style::studio;
  /// Not given: perspective for the automatic view, else orthographic.
  std::optional<Projection> projection{};
  bool transparent = false;  ///< no floor and no wall
  bool whole_cell = false;   ///< the particles' cell is in the picture, too
};

/// What an auto scene shows, beside spheres.
struct Subject {
  bool molecule = true;          ///< see viewpoint_of()
  std::vector<Vec3d> corners{};  ///< further points of the picture
};

/// A sphere that stands around the particles: floor, wall or light blocker.
struct SceneryObject {
  std::string_view name;  ///< of its material: "ground", "wall" or, for the light blocker, "flag"
  Material material;
  Sphere sphere{};  ///< `material` is not set
};

/// Returns the scenery of such a view in its order. The spheres are not placed yet.
std::vector<SceneryObject> scenery_of(const Viewing& viewing);

/// Camera, light and scenery for a picture of spheres as a paper would print it. The camera looks
/// from where the spheres show most, or from where the user wants, through a long lens. Every
/// sphere is inside the picture.
///
/// - ground: a pale floor under the lowest sphere or, for a view that does not look down on it, a
/// pale
///   wall behind the farthest sphere. It fills the background.
/// - wall: a dark wall behind all spheres. It fills the background and is too far away for shadows.
/// - flag (as photographers call a light blocker): a black sphere outside the picture that blocks
/// the
///   light of the sky from one side. So light comes from the upper left of the picture.
struct Surroundings {
  Camera camera;  ///< a pinhole; tan_half_vfov is set
  Sky sky;
  std::vector<SceneryObject> scenery;  ///< those of scenery_of(), placed
};

/// The material of particles of which only positions are known.
inline constexpr Material plain_material{MaterialType::diffuse, {0.35, 0.48, 0.65}, 0, 1};

/// Returns the surroundings of `spheres`, which are not empty, for a picture `aspect` (> 0) times
/// as wide as high. Scaling spheres by a power of two scales them exactly, except for rounding at
/// the ends of double's range.
///
/// Throws InputError, without a file's name, if camera or scenery would lie beyond
/// limits::max_length, or if the group is too far from the origin for the precision of its
/// coordinates.
Surroundings surroundings_of(std::span<const Sphere> spheres, double aspect,
                             const Viewing& viewing = {}, const Subject& subject = {},
                             int threads = 1);

}  // namespace parray::input
