#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings.h"

namespace parray::scene {

/// What a scene contains and therefore needs; everything else costs it nothing.
struct Requirements {
  std::size_t spheres = 0;
  std::size_t diffuse = 0;  ///< spheres of each kind
  std::size_t metal = 0;
  std::size_t dielectric = 0;
  bool fuzz = false;           ///< some metal is not a perfect mirror
  bool lens = false;           ///< aperture > 0
  bool one_radius = false;     ///< all spheres share one radius
  double smallest_radius = 0;  ///< 0 without spheres
  double largest_radius = 0;

  // How well single precision resolves what is seen. Lengths are in the scene's unit.
  Vec3d origin;  ///< scene_origin(): what positions are measured from
  /// Largest coordinate of a centre, or of where camera rays begin, from there, or radius.
  double extent = 0;
  /// Farthest that storing the spheres in single precision moves a coordinate or a radius.
  double stored_shift = 0;
  double nearest = 0;      ///< from the eye to the nearest surface; 0 without spheres
  double view_height = 0;  ///< of what the picture shows at that distance

  /// How far computing in single precision moves surfaces: half an ulp of the largest number.
  [[nodiscard]] double computed_shift() const;
  /// extent / smallest_radius: the largest distance in radii; 0 without spheres.
  [[nodiscard]] double spread() const;

  /// Names for the report: "diffuse", "metal", "fuzz", "dielectric", "lens", ...
  [[nodiscard]] std::vector<std::string> features() const;
};

/// The same for any number of threads.
Requirements requirements_of(const Scene& scene, int threads = 1);

/// Settings with every `automatic` decided, and why.
struct ResolvedSettings {
  RenderSettings settings;
  std::string precision_reason;
  std::string accelerator_reason;
};

/// Decides what was left automatic, from the scene alone, so that everybody decides alike.
///
/// Precision: single precision moves surfaces, by computing (computed_shift()) or only by storing
/// the spheres (stored_shift). What moves by little enough of the smallest radius, and of the
/// picture's height where surfaces are nearest, is unseen. f32 if computing goes unseen, mixed if
/// storing does, else f64.
ResolvedSettings resolve_settings(const Requirements& requirements, const RenderSettings& asked);

}  // namespace parray::scene
