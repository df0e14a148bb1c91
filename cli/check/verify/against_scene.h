#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/check/verify/verified_picture.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"

/// A finished picture held against its scene: pixels are traced again.
namespace parray::verify {

/// What traced pixels say of the error (RMSE, linear radiance) that a file states.
struct ErrorCheck {
  double stated = 0;
  double traced = 0;
  /// Standard error of `traced` by the choice of pixels; 0: all pixels were traced.
  double uncertainty = 0;
  /// All pixels were traced, and give another error or interval; or some give far more.
  bool wrong = false;
};

struct Findings {
  std::uint64_t traced = 0;          ///< pixels
  std::vector<RetracedPixel> wrong;  ///< of these, by row, then column
  /// Extra channels that were traced, and how many of the pixels have other values there.
  std::map<std::string, std::uint64_t> channels;
  std::optional<ErrorCheck> error;  ///< nothing: it is unknown, or the pixels are too few

  [[nodiscard]] bool right() const;
};

struct PixelChoice {
  std::uint64_t pixels = 0;
  bool all = false;
  std::uint64_t seed = 0;
};

/// Traces pixels of the picture again: colours, alpha and extra channels. `settings`: the recipe's,
/// resolved. Throws InputError where the file does not say how many samples a pixel has.
Findings check_against_scene(const VerifiedPicture& picture, const Scene& scene,
                             const RenderSettings& settings, const PixelChoice& choice,
                             int threads);

}  // namespace parray::verify
