#pragma once

#include <cstdint>
#include <vector>

#include "common/rooms.h"

namespace parray::scene {

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

}  // namespace parray::scene
