#pragma once

#include <cstdint>
#include <vector>

#include "common/math/vec.h"

/// The scene in the form that all parts of the program share. Lengths are in the scene's own unit,
/// colours are linear RGB. Plain data in double precision; immutable once loaded, so any thread may
/// read it.
namespace parray::scene {

enum class MaterialType : std::uint8_t { diffuse = 0, metal = 1, dielectric = 2 };  // wire values

/// What a surface does with light; common/trace/integrator/material.h has the formulas. Values that
/// the type does not use stay at their defaults, so that equal surfaces compare equal.
struct Material {
  MaterialType type = MaterialType::diffuse;
  Vec3d albedo{1, 1, 1};  ///< diffuse, metal: each component in [0, 1]
  /// Metal: radius of the ball, around the end of the unit mirror direction, in which a reflected
  /// ray ends; in [0, 1]. 0: a perfect mirror.
  double fuzz = 0;
  double ior = 1;  ///< dielectric: index relative to the surroundings, > 0 (a bubble: < 1)

  friend bool operator==(const Material&, const Material&) = default;
};

struct Sphere {
  Vec3d center;
  double radius = 1;           ///< > 0
  std::uint32_t material = 0;  ///< index into Scene::materials

  friend bool operator==(const Sphere&, const Sphere&) = default;
};

/// All points within `radius` of the segment between two points.
struct Capsule {
  Vec3d from;
  Vec3d to;           ///< equal to `from`, or at least 2 limits::min_radius away along an axis
  double radius = 1;  ///< > 0
  std::uint32_t material = 0;  ///< index into Scene::materials

  friend bool operator==(const Capsule&, const Capsule&) = default;
};

/// The starts and directions of a camera's rays: see common/trace/integrator/camera_rays.h.
enum class Projection : std::uint8_t {
  perspective,  ///< from one eye through all pixels
  orthographic  ///< parallel rays, so that size does not depend on distance
};

/// A thin-lens camera; the lens is a uniform disc. Values that the projection does not use are 0,
/// so that equal cameras compare equal.
struct Camera {
  Vec3d look_from{13, 2, 3};   ///< the eye; centre of the lens, or of an orthographic film
  Vec3d look_at{0, 0, 0};      ///< the point in the middle of the picture
  Vec3d up{0, 1, 0};           ///< points up in the picture; any length > 0, not along the view
  double vfov = 20;            ///< perspective: vertical angle of view, degrees, in (0, 180)
  double aperture = 0.1;       ///< lens diameter, >= 0; 0 is a pinhole
  double focus_distance = 10;  ///< from the eye to the plane that is in focus, > 0
  /// tan(vfov / 2). The loader of the scene computes it once and sends its bits. It is the only
  /// value that needs libm, which gives different last bits on different machines.
  double tan_half_vfov = 0;
  Projection projection = Projection::perspective;
  double view_height = 0;  ///< orthographic: height of the picture in the scene's unit, > 0

  friend bool operator==(const Camera&, const Camera&) = default;
};

/// The radiance of a ray that leaves the scene: lerp(horizon, zenith, (y + 1) / 2) with the y of
/// its direction.
struct Sky {
  Vec3d horizon{1, 1, 1};
  Vec3d zenith{0.5, 0.7, 1.0};

  friend bool operator==(const Sky&, const Sky&) = default;
};

struct Scene {
  Camera camera;
  Sky sky;
  std::vector<Material> materials;  ///< distinct, in the order in which shapes first use them
  std::vector<Sphere> spheres;      ///< input order; closest-hit ties go to the lower index
  std::vector<Capsule> capsules;    ///< input order; shapes are numbered spheres first

  /// Returns the material of the shape with this number.
  [[nodiscard]] const Material& material_of(std::size_t shape) const {
    const std::uint32_t number = shape < spheres.size() ? spheres[shape].material
                                                        : capsules[shape - spheres.size()].material;
    return materials[number];
  }

  friend bool operator==(const Scene&, const Scene&) = default;
};

}  // namespace parray::scene
