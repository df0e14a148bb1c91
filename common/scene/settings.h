#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"

namespace parray::scene {

/// What decides the bits of a sample, together with the scene.
struct PictureSettings {
  std::uint32_t width = 1200;    ///< pixels, 1 .. limits::max_image_side
  std::uint32_t height = 800;    ///< pixels, 1 .. limits::max_image_side
  std::uint32_t max_depth = 10;  ///< most ray segments of a path, 1 .. limits::max_depth
  std::uint64_t seed = 1;        ///< of the random numbers: another seed gives other noise
  Sampler sampler = Sampler::sobol;
  Precision precision = Precision::automatic;  ///< `automatic` until resolve_settings() has run

  friend bool operator==(const PictureSettings&, const PictureSettings&) = default;
};

/// When a picture is complete, and which pixels get its samples: see common/adaptive/passes.h. The
/// first limit that is reached ends the picture; 0: no such limit.
struct StopSettings {
  std::uint32_t samples_per_pixel = 500;  ///< most, on average: 1 .. limits::max_samples_per_pixel
  bool adaptive = false;                  ///< pixels with more noise get more samples
  /// Largest RMSE of the picture, in linear radiance.
  double target_error = 0;
  bool target_denoised = false;  ///< target_error is for the denoised picture
  /// Largest half-width of the 95 % confidence intervals of 99 % of the pixel values, in linear
  /// radiance.
  double target_half_width = 0;
  double time_limit = 0;  ///< seconds, from start to end
  /// Samples of each pass, all pixels together, from the report of a picture to repeat. If not
  /// empty, the picture has these passes, and no limit above applies.
  std::vector<std::uint64_t> passes{};

  /// Returns whether common/adaptive/passes.h decides the passes, or `passes` lists them.
  [[nodiscard]] bool in_passes() const {
    return adaptive || target_error > 0 || target_half_width > 0 || time_limit > 0 ||
           !passes.empty();
  }

  friend bool operator==(const StopSettings&, const StopSettings&) = default;
};

/// How the work is divided and done. These settings never change the bits of a picture.
struct WorkSettings {
  AcceleratorKind accelerator = AcceleratorKind::automatic;
  Isa isa = Isa::automatic;  ///< a worker that lacks it takes the best it has
  SchedulePolicy schedule = SchedulePolicy::weighted;
  RowOrder row_order = RowOrder::automatic;  ///< automatic: interleaved with weighted
  bool progressive = false;  ///< trace one sample of every pixel first, for an early preview
  bool replicates = false;   ///< keep the two halves of the samples (image/picture_bytes.h)

  friend bool operator==(const WorkSettings&, const WorkSettings&) = default;
};

/// How a scene is to be rendered. Without a time limit, the scene, PictureSettings and StopSettings
/// determine the bits of the picture. A function takes the part that it needs.
struct RenderSettings : PictureSettings, StopSettings, WorkSettings {
  [[nodiscard]] const PictureSettings& picture() const { return *this; }
  [[nodiscard]] const StopSettings& stop() const { return *this; }
  [[nodiscard]] const WorkSettings& work() const { return *this; }

  /// Returns whether there may be passes after the first.
  [[nodiscard]] bool has_passes() const { return in_passes() || progressive; }

  friend bool operator==(const RenderSettings&, const RenderSettings&) = default;
};

/// Throws InputError that names the first value out of its range.
void check_settings(const RenderSettings& settings);

}  // namespace parray::scene
