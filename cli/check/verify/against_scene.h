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

/// Comparison of the error that the file states (RMSE, linear radiance) with the error of the
/// traced pixels.
struct ErrorCheck {
  double stated = 0;  ///< in the file
  double traced = 0;  ///< estimated from the samples of the traced pixels
  /// Standard error of `traced` from the random choice of pixels; 0 if all pixels were traced.
  double uncertainty = 0;
  /// If all pixels were traced: their error, or its 95 % interval, has other bits than the stated
  /// one. Otherwise: their mean square error is more than 5 standard errors above the stated one.
  bool wrong = false;
};

struct VerificationResults {
  std::uint64_t traced = 0;          ///< number of traced pixels
  std::vector<RetracedPixel> wrong;  ///< pixels whose colour or alpha differs, by row, then column
  /// Checked extra channels: name, and number of traced pixels that have another value in the file.
  std::map<std::string, std::uint64_t> channels;
  /// Empty in three cases: the file states no error; a traced pixel has fewer than 2 samples; or
  /// fewer than 30 pixels were traced, and these are not all.
  std::optional<ErrorCheck> error;

  /// Returns whether colours, alpha, channels and stated error are all right.
  [[nodiscard]] bool right() const;
};

/// Which pixels to trace again.
struct PixelChoice {
  std::uint64_t pixels = 0;  ///< number of random pixels
  bool all = false;          ///< all pixels; `pixels` and `seed` do not count
  std::uint64_t seed = 0;    ///< of the random choice
};

/// Traces pixels of the picture again and compares colours, alpha and extra channels. `settings`:
/// the resolved settings of the recipe. Precondition: misfit_of(picture) is empty. Throws
/// InputError as sample_counts() does.
VerificationResults check_against_scene(const VerifiedPicture& picture, const Scene& scene,
                                        const RenderSettings& settings, const PixelChoice& choice,
                                        int threads);

}  // namespace parray::verify
