#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/adaptive/allocation.h"
#include "common/image/framebuffer.h"
#include "common/scene/settings.h"

namespace parray::adaptive {

/// Whether `samples` more are so few that a picture of `traced`, once it is adaptive, keeps to the
/// proportions that it has.
bool is_little(std::uint64_t samples, std::uint64_t traced);

/// What placing samples has found out of a picture for later passes: weights of SampleShares, from
/// when it had `samples`.
struct NoiseWeights {
  std::vector<float> weights{};
  std::uint64_t samples = 0;
};

/// Where the samples of a picture's next pass go: a function of the picture's state and of what it
/// is to stop at, in arithmetic that is the same everywhere. What is found out for one question is
/// kept for the next.
///
/// All pixels get the same unless settings.adaptive; then from pilot_samples on, and where
/// adaptive_pays(), as common/adaptive/allocation.h says, for equal half-widths with a
/// target_half_width and for the least RMSE without. A pass that adds little keeps to the
/// proportions that there are. How many samples that takes is foreseen from some rows of a large
/// picture.
class Placement {
 public:
  /// Refers to `state`, which has pixels, and to `found`: what earlier passes of the same picture
  /// have found is used until there are twice as many samples, and then replaced.
  Placement(const FramebufferView& state, const StopSettings& settings,
            NoiseWeights* found = nullptr);

  [[nodiscard]] std::uint64_t traced() const { return traced_; }  ///< all pixels together

  /// Whether a pass of `samples`, all pixels together, gives every pixel the same.
  [[nodiscard]] bool is_even(std::uint64_t samples) { return kind_of(samples) == Kind::even; }
  /// Samples, all pixels together, with which the mean square error, or the square of the
  /// half-width of 99 % of the pixels, is expected to be `share` of what it is, 0 < share <= 1.
  [[nodiscard]] double total_for(double share);
  /// Samples that each pixel has after a pass of `samples` more; none has fewer than before. More
  /// than asked for, where equal counts need them.
  [[nodiscard]] std::vector<std::uint32_t> counts(std::uint64_t samples);
  /// The samples that every pixel has, and those after the pass, where all have the same before and
  /// after; else zeros.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> even_counts(std::uint64_t samples);

 private:
  enum class Kind : std::uint8_t { even, as_before, by_noise };

  [[nodiscard]] Kind kind_of(std::uint64_t samples);
  [[nodiscard]] std::uint32_t each_of(std::uint64_t total) const;
  [[nodiscard]] const Allocation& foreseen();
  [[nodiscard]] std::vector<std::uint32_t> by_noise(double total);

  FramebufferView state_;
  bool adaptive_;
  bool half_widths_;
  std::size_t stride_;  ///< of the rows that are asked
  std::uint64_t traced_ = 0;
  std::uint32_t least_ = 0;  ///< of a pixel
  std::uint32_t most_ = 0;
  std::optional<bool> pays_;
  std::optional<Allocation> foreseen_;
  NoiseWeights* found_;
};

}  // namespace parray::adaptive
