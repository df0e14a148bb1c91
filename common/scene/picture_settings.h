#pragma once

#include <cstdint>

#include "common/scene/setting_choices.h"

namespace parray::scene {

/// These settings and the scene decide the bits of a sample.
struct PictureSettings {
  std::uint32_t width = 1200;    ///< pixels, 1 .. limits::max_image_side
  std::uint32_t height = 800;    ///< pixels, 1 .. limits::max_image_side
  std::uint32_t max_depth = 10;  ///< most ray segments of a path, 1 .. limits::max_depth
  std::uint64_t seed = 1;        ///< of the random numbers: another seed gives other noise
  Sampler sampler = Sampler::sobol;
  Precision precision = Precision::automatic;  ///< `automatic` until resolve_settings() has run

  friend bool operator==(const PictureSettings&, const PictureSettings&) = default;
};

}  // namespace parray::scene
