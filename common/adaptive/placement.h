#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/adaptive/allocation.h"
#include "common/image/framebuffer.h"
#include "common/scene/settings_fwd.h"

namespace parray::adaptive {

/// Returns whether a pass of `samples` adds little: less than a third of the `traced` samples.
bool is_little(std::uint64_t samples, std::uint64_t traced);

/// Weights of SampleShares that a placement computed when the picture had `samples`, for later
/// passes.
struct NoiseWeights {
  std::vector<float> weights{};
  std::uint64_t samples = 0;
};

/// Decides how many samples each pixel gets in the next pass of a picture. The result depends only
/// on the picture's state and on its StopSettings, and has the same bits on every machine. The
/// object caches intermediate results of its functions.
///
/// All pixels get the same number of samples unless settings.adaptive is set. With it, Allocation
/// (allocation.h) places samples once every pixel has pilot_samples. With a target_half_width,
/// samples are placed for equal half-widths. Otherwise they are placed for the least RMSE, and only
/// if that costs clearly less than equal numbers of samples. Without a target_half_width, a pass
/// that adds little (is_little()) keeps the present proportions of counts. Equal counts then stay
/// equal in a pass of less than half of the present samples. In a large picture, the prediction of
/// how many samples are needed uses only some rows.
class Placement {
 public:
  /// Refers to `state`, which must have pixels, and to `found`. `found` holds the weights that
  /// earlier passes of the same picture computed, or is empty. They are used until the picture has
  /// twice as many samples; then the placement replaces them by new weights. `found` null: weights
  /// are not kept.
  Placement(const FramebufferView& state, const StopSettings& settings,
            NoiseWeights* found = nullptr);

  [[nodiscard]] std::uint64_t traced() const { return traced_; }  ///< all pixels together

  /// Returns whether a pass of `samples`, over all pixels, gives every pixel the same number.
  [[nodiscard]] bool is_even(std::uint64_t samples) { return kind_of(samples) == Kind::even; }
  /// Returns the total samples, over all pixels, that are expected to reduce the mean square error
  /// (with a target_half_width: the square of the half-width of 99 % of the pixels) to `share` of
  /// its present value, 0 < share <= 1.
  [[nodiscard]] double total_for(double share);
  /// Returns the number of samples of each pixel after a pass of `samples` more, over all pixels;
  /// no pixel has fewer than before. If all pixels get the same number, the total is rounded up.
  /// Otherwise it is that of SampleShares::counts_of().
  [[nodiscard]] std::vector<std::uint32_t> counts(std::uint64_t samples);
  /// Returns the samples per pixel before and after the pass if all pixels have the same number
  /// both times; otherwise zeros.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> even_counts(std::uint64_t samples);

 private:
  enum class Kind : std::uint8_t { even, as_before, by_noise };

  [[nodiscard]] Kind kind_of(std::uint64_t samples);
  [[nodiscard]] std::uint32_t each_of(std::uint64_t total) const;
  [[nodiscard]] const Allocation& prediction();
  [[nodiscard]] std::vector<std::uint32_t> by_noise(double total);

  FramebufferView state_;
  bool adaptive_;
  bool half_widths_;
  std::size_t stride_;  ///< of the rows that are read
  std::uint64_t traced_ = 0;
  std::uint32_t least_ = 0;  ///< fewest samples of a pixel
  /// Most samples of a pixel.
  std::uint32_t most_ = 0;
  std::optional<bool> pays_;
  std::optional<Allocation> prediction_;
  NoiseWeights* found_;
};

}  // namespace parray::adaptive
