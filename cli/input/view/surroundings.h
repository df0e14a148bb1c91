#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cli/input/view/free_area.h"
#include "cli/input/view/style.h"
#include "cli/input/view/view.h"
#include "common/scene/scene.h"

namespace parray::input {

struct SceneFile;

/// How an automatic scene shows its particles.
struct Viewing {
  View view = View::automatic;
  Style style = Style::studio;
  /// Not given: perspective for the automatic view, orthographic for all others.
  std::optional<Projection> projection{};
  bool transparent = false;  ///< no floor and no wall
  bool whole_cell = false;   ///< the picture includes the particles' cell
  Turning turning{};
  double zoom = 1;  ///< size of the particles relative to the usual size, in zoom_range
  /// Returns the places of the labels in the picture of a scene that has a camera. An empty
  /// function means no labels.
  std::function<LabelPlaces(const SceneFile&)> labels{};
  /// Spheres and points of other frames that the picture includes, too. They do not determine the
  /// direction of view. If there are other spheres, the axis of the turntable goes through the
  /// middle of the bounds of these spheres, points and Subject::corners. Otherwise it goes through
  /// the middle of the particles.
  std::vector<Sphere> other_spheres{};
  std::vector<Vec3d> other_points{};
  /// True for films of a turntable: the picture includes `other_spheres`, `other_points`, and
  /// capsules and corners of the Subject at every angle, and the centre of a floor lies on the
  /// turntable's axis. The picture includes the spheres of the particles at every angle only if
  /// `other_spheres` has them, too.
  bool turns = false;
};
inline constexpr NumberRange zoom_range{0.1, 100};

/// What an automatic scene shows besides the spheres of particles.
struct Subject {
  bool molecule = true;                 ///< the automatic view is that of a molecule: view.h
  std::vector<Vec3d> corners{};         ///< points that the picture must include
  std::span<const Capsule> capsules{};  ///< sticks, arrows and edges of the cell
  /// Returns the places of the labels. The camera is the one that a picture without labels would
  /// have. An empty function means no labels.
  std::function<LabelPlaces(const Camera&)> labels{};
};

/// A large sphere beside the group of particles: a floor, a wall or a light blocker.
struct SceneryObject {
  std::string_view name;  ///< of the material: "ground", "wall" or "flag" (the light blocker)
  Material material;
  Sphere sphere{};  ///< `material` is not set
};

/// Returns the objects that `viewing` needs. First comes the ground (style `studio`) or the wall
/// (style `night`), unless the background is transparent. Then comes the light blocker, unless the
/// style is `flat`, which has equal light from all sides. The spheres have no position yet.
std::vector<SceneryObject> scenery_of(const Viewing& viewing);

/// Camera, light and scenery for a picture of spheres. The camera looks from the direction that
/// viewpoint_of() chooses. A perspective camera has a vertical angle of view of 20 degrees, or
/// less if the user zooms in. Every sphere and capsule is inside the picture and outside all
/// labels, unless the user zooms in. The camera moves sideways and away from the spheres for this,
/// and keeps its direction.
///
/// - ground: a pale floor under the lowest sphere or capsule. For a view that does not look down on
///   the floor, the ground stands upright: a pale wall behind the farthest sphere. The ground fills
///   the background.
/// - wall: a dark wall behind all spheres. It fills the background. No shadow falls on it, because
///   it is too far away.
/// - flag (the photographers' word for a light blocker): a black sphere outside the picture. It
///   blocks the light of the sky from one side, so that light comes from the upper left of the
///   picture.
struct Surroundings {
  Camera camera;  ///< a pinhole; a perspective one has tan_half_vfov
  Sky sky;
  std::vector<SceneryObject> scenery;  ///< the objects of scenery_of(), with positions
  /// The axis around which camera and scenery turn in films of a turntable. It points away from the
  /// ground, along Viewpoint::off_ground, or upwards in the picture if off_ground points to the
  /// viewer. If Viewing::turns is set, a turn changes only which side of the spheres the picture
  /// shows.
  TurnAxis axis{};
};

/// The material of particles in files without colours, elements and types.
inline constexpr Material plain_material{MaterialType::diffuse, {0.35, 0.48, 0.65}, 0, 1};

/// Returns the surroundings of `spheres`, which are not empty. `aspect` (> 0) is the width of the
/// picture divided by its height. The result does not depend on the number of `threads`. Scaling
/// the spheres by a power of two scales the surroundings exactly, except for rounding at the ends
/// of double's range.
///
/// Throws InputError, which names no file, if camera or scenery would lie beyond
/// limits::max_length. Throws it also if the group is too far from the origin for the precision of
/// its coordinates. Passes on the errors of viewpoint_of() and free_area().
Surroundings surroundings_of(std::span<const Sphere> spheres, double aspect,
                             const Viewing& viewing = {}, const Subject& subject = {},
                             int threads = 1);

}  // namespace parray::input
