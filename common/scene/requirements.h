#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings.h"

namespace parray {

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
  /// Largest coordinate that tracing meets, relative to scene_origin(): of a sphere's surface or of
  /// the camera.
  double extent = 0;

  /// Largest coordinate of a centre in units of its own radius: what storing it in single precision
  /// costs that sphere.
  double own_spread = 0;

  /// extent / smallest_radius: how many smallest radii fit the numbers that are added. Rounding
  /// errors relative to the smallest sphere grow with it.
  [[nodiscard]] double spread() const;
  /// Names for the report: "diffuse", "metal", "fuzz", "dielectric", "lens", ...
  [[nodiscard]] std::vector<std::string> features() const;
};

Requirements requirements_of(const Scene& scene);

/// Settings with every `automatic` decided, and why.
struct ResolvedSettings {
  RenderSettings settings;
  std::string precision_reason;
  std::string accelerator_reason;
};

/// Decides what was left automatic, from the scene alone, so that everybody decides alike.
ResolvedSettings resolve_settings(const Requirements& requirements, const RenderSettings& asked);

}  // namespace parray
