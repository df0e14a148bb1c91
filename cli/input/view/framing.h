#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "cli/input/view/view.h"
#include "common/scene/scene.h"

/// Where the camera of a portrait stands, so that everything is in the picture.
namespace parray::input {

inline constexpr double portrait_vfov = 20;  ///< degrees: a long lens, so that near looks no larger

/// The spheres' extremes along one axis of the picture, as lines through the eye see them.
///
/// A sphere at (x, z), z towards the eye, lies inside a half-plane through the eye at (ex, ez) that
/// leans by the tangent t if x + t z + r sqrt(1 + t^2) <= ex + t ez; and with -x if -ex. With t = 0
/// the lines are parallel: extents as an orthographic camera sees them.
struct Wedge {
  explicit Wedge(double tangent) : t(tangent), secant(square_root(1 + tangent * tangent)) {}

  void add(double x, double z, double radius);
  void add(const Wedge& other);
  /// Nearest z of an eye that has everything in the wedge, t > 0; and the x that centres it.
  [[nodiscard]] double distance() const { return (right + left) / (2 * t); }
  [[nodiscard]] double middle() const { return (right - left) / 2; }
  [[nodiscard]] double width() const { return right + left; }  ///< t = 0

  double t;
  double secant;
  double right = -std::numeric_limits<double>::infinity();
  double left = -std::numeric_limits<double>::infinity();
};

/// What a portrait needs to know of all spheres: extremes, which are the same in any order.
struct Extent {
  Extent(Projection projection, double aspect);

  void add(const Sphere& sphere, const Viewpoint& view);
  /// `later`: of spheres after those of this one.
  void add(const Extent& later);

  Wedge vertical;
  Wedge horizontal;
  double reach = 0;  ///< radius, around the frame's centre, of a ball that holds all spheres
  double bottom = std::numeric_limits<double>::infinity();
  Sphere lowest{};  ///< the first of those farthest towards the ground
};

/// Of spheres and of points, as the corners of a cell, in a picture `aspect` times as wide as high.
/// The same for any number of `threads`.
Extent extent_of(std::span<const Sphere> spheres, std::span<const Vec3d> points,
                 const Viewpoint& view, Projection projection, double aspect, int threads);

/// A pinhole that has all of `extent` in the middle 85 % of its picture, along the tighter axis
/// exactly.
Camera camera_for(const Extent& extent, const Viewpoint& view, Projection projection,
                  double aspect);

}  // namespace parray::input
