#pragma once

#include <cstdint>
#include <vector>

#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/material.h"
#include "common/trace/integrator/start_shapes.h"

/// Arguments for the functions of path.h, in containers of the host (for the CPU, not for a GPU).
namespace parray::trace {

/// Everything that a path can meet: a PathScene. Positions are relative to scene_origin().
/// Immutable; all threads and all pictures of the scene share it.
template <typename Real>
struct TraceScene {
  std::vector<SphereShape<Real>> spheres;
  std::vector<CapsuleShape<Real>> capsules;  ///< numbered after the spheres
  std::vector<std::uint32_t> material_of;    ///< index in `surfaces`, per shape
  std::vector<MaterialParameters<Real>> surfaces;
  SkyGradient<Real> sky;

  [[nodiscard]] std::uint32_t shape_count() const {
    return static_cast<std::uint32_t>(spheres.size() + capsules.size());
  }
};

/// How the paths of a picture begin and end. Immutable; all threads share it.
template <typename Real>
struct PathEnds {
  CameraRays<Real> view;
  StartShapes start;            ///< numbers of shapes that paths may begin inside of; mostly empty
  std::uint32_t max_depth = 1;  ///< ray segments of the longest path
};

}  // namespace parray::trace
