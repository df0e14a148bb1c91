#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

namespace parray::scene {

/// The contents of a scene, which determine what its render needs. Features that it lacks cost
/// nothing.
struct Requirements {
  std::size_t spheres = 0;
  std::size_t capsules = 0;
  // Numbers of shapes with each type of material.
  std::size_t diffuse = 0;
  std::size_t metal = 0;
  std::size_t dielectric = 0;
  bool fuzz = false;           ///< some metal is not a perfect mirror
  bool lens = false;           ///< aperture > 0
  bool one_radius = false;     ///< all shapes share one radius
  double smallest_radius = 0;  ///< 0 without shapes
  double largest_radius = 0;

  // Data on how well single precision resolves the visible scene. Lengths are in the scene's unit.
  Vec3d origin;  ///< scene_origin(): the origin of positions
  /// The largest of all coordinates of centres, of capsules' ends and of starts of camera rays,
  /// relative to `origin`, and of all radii.
  double extent = 0;
  /// The largest change of a coordinate or a radius by storing the shapes in single precision.
  double stored_shift = 0;
  double nearest = 0;      ///< distance from look_from to the nearest surface; 0 without shapes
  double view_height = 0;  ///< height of the visible area at that distance

  /// Returns the distance by which computing in single precision moves surfaces: half an ulp of the
  /// largest number.
  [[nodiscard]] double computed_shift() const { return 0x1p-24 * extent; }
  [[nodiscard]] std::size_t shapes() const { return spheres + capsules; }
  /// Returns extent / smallest_radius: the extent in smallest radii; 0 without shapes.
  [[nodiscard]] double spread() const { return shapes() == 0 ? 0 : extent / smallest_radius; }

  /// Returns names for the report of what the scene has: "diffuse", "metal", "fuzz", "dielectric",
  /// "lens", "many-radii", "capsules".
  [[nodiscard]] std::vector<std::string> features() const;
};

/// Computes the requirements of a scene. The result is the same for any number of threads.
Requirements requirements_of(const Scene& scene, int threads = 1);

/// Settings in which every `automatic` except that of `isa` is decided, with the reasons: texts for
/// the report; "asked for" if the setting was not `automatic`.
struct ResolvedSettings {
  Boxed<RenderSettings> settings;
  std::string precision_reason;
  std::string accelerator_reason;
};

/// Decides all `automatic` settings except `isa` from the scene and the other settings alone, so
/// that every process decides alike.
///
/// Precision: single precision moves surfaces, either by computing (computed_shift()) or only by
/// storing the shapes (stored_shift). A shift is invisible if it is a small enough part of the
/// smallest radius and of the picture's height at the nearest surface. The result is f32 if the
/// shift of computing is invisible, mixed if that of storing is, otherwise f64.
ResolvedSettings resolve_settings(const Requirements& requirements, const RenderSettings& asked);

}  // namespace parray::scene
