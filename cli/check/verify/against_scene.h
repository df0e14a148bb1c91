#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/check/verify/verified_picture.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

/// Checks a finished picture against its scene: traces pixels again.
namespace parray::verify {

/// Comparison of the file's stated error (RMSE, linear radiance) with the error of the traced
/// pixels.
struct ErrorCheck {
  double stated = 0;
  double traced = 0;
  /// Standard error of `traced` from the random choice of pixels; 0 if all pixels were traced.
  double uncertainty = 0;
  /// If all pixels were traced: their error or its interval differs from the stated one. Otherwise:
  /// the traced pixels have a far larger error than the stated one.
  bool wrong = false;
};

struct VerificationResults {
  std::uint64_t traced = 0;          ///< pixels
  std::vector<RetracedPixel> wrong;  ///< wrong pixels, by row, then column
  /// Checked extra channels, with the number of pixels that have other values.
  std::map<std::string, std::uint64_t> channels;
  /// Empty: the file states no error, the pixels are too few, or one has fewer than 2 samples.
  std::optional<ErrorCheck> error;

  [[nodiscard]] bool right() const;
};

struct PixelChoice {
  std::uint64_t pixels = 0;
  bool all = false;
  std::uint64_t seed = 0;
};

/// Traces pixels of the picture again: colours, alpha and extra channels. `settings`: the resolved
/// settings of the recipe. Throws the errors of sample_counts().
VerificationResults check_against_scene(const VerifiedPicture& picture, const Scene& scene,
                                        const RenderSettings& settings, const PixelChoice& choice,
                                        int threads);

}  // namespace parray::verify
