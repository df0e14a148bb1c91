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
  std::uint32_t max_depth = 10;  ///< ray segments a path, 1 .. limits::max_depth
  std::uint64_t seed = 1;
  Sampler sampler = Sampler::sobol;
  Precision precision = Precision::automatic;  ///< `automatic` until resolve_settings() has run

  friend bool operator==(const PictureSettings&, const PictureSettings&) = default;
};

/// How many samples the pixels get: when to stop, and where the samples go. See
/// common/adaptive/passes.h. Whichever limit is reached first ends the picture; 0: no such limit.
struct StopSettings {
  std::uint32_t samples_per_pixel = 500;  ///< mean, at most: 1 .. limits::max_samples_per_pixel
  bool adaptive = false;                  ///< pixels with more noise get more samples
  double target_error = 0;                ///< RMSE of the picture, in linear radiance
  bool target_denoised = false;           ///< that of the denoised picture
  double target_half_width = 0;           ///< of 99 % of the pixels' 95 % intervals, likewise
  double time_limit = 0;                  ///< seconds; what came of it is in `passes`
  /// Samples of each pass, all pixels together, as a report gives them: decides instead of all
  /// limits above, so that a picture can be repeated. Empty as a rule.
  std::vector<std::uint64_t> passes{};

  /// Whether the passes after the first depend on what earlier ones have found.
  [[nodiscard]] bool in_passes() const {
    return adaptive || target_error > 0 || target_half_width > 0 || time_limit > 0 ||
           !passes.empty();
  }

  friend bool operator==(const StopSettings&, const StopSettings&) = default;
};

/// How the work is cut and done: the same bits whatever these say.
struct WorkSettings {
  AcceleratorKind accelerator = AcceleratorKind::automatic;
  Isa isa = Isa::automatic;  ///< a worker that lacks it takes the best it has
  SchedulePolicy schedule = SchedulePolicy::weighted;
  RowOrder row_order = RowOrder::automatic;  ///< automatic: interleaved with weighted
  bool progressive = false;  ///< first one sample of every pixel, so that there is a picture early
  bool replicates = false;   ///< the halves of its samples are kept with the picture

  friend bool operator==(const WorkSettings&, const WorkSettings&) = default;
};

/// How a scene is to be rendered. Equal first and second parts, and the same scene, are the same
/// picture; a function takes the part that it needs.
struct RenderSettings : PictureSettings, StopSettings, WorkSettings {
  [[nodiscard]] const PictureSettings& picture() const { return *this; }
  [[nodiscard]] const StopSettings& stop() const { return *this; }
  [[nodiscard]] const WorkSettings& work() const { return *this; }

  /// Whether there may be passes after the first.
  [[nodiscard]] bool has_passes() const { return in_passes() || progressive; }

  friend bool operator==(const RenderSettings&, const RenderSettings&) = default;
};

/// Throws InputError naming the first value out of its range.
void check_settings(const RenderSettings& settings);

}  // namespace parray::scene
