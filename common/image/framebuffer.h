#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/image/passes.h"
#include "common/image/row_block.h"
#include "common/scene/settings.h"

namespace parray {

/// The sums of a whole image, and how many samples of each pixel they hold.
/// Plain state; one thread at a time.
class Framebuffer {
 public:
  /// Sizes and row order from settings that resolve_settings() has completed.
  explicit Framebuffer(const RenderSettings& settings);

  /// Begins a pass at whose end pixel i (image order) has targets[i] samples, no fewer than now.
  /// Only between passes: every sample of the one before is in. Throws std::logic_error.
  void begin_pass(const std::vector<std::uint32_t>& targets);
  /// The smallest rectangle around the samples of the pass under way; without units if it has none.
  [[nodiscard]] const WorkRect& pass_rect() const { return pass_rect_; }
  /// Samples that each pixel (image order) gets from the pass under way; empty: all the same.
  [[nodiscard]] const std::vector<SampleRange>& pass_samples() const { return pass_; }
  /// Which samples each pixel has of a rectangle, in position order. Empty: every one.
  [[nodiscard]] std::vector<SampleRange> samples_of(const WorkRect& rect) const;
  /// How many that is, all pixels together.
  [[nodiscard]] std::uint64_t sample_count(const WorkRect& rect) const;

  /// Adds a block. The caller vouches that its samples are not in yet (LeaseTable does).
  /// Throws std::logic_error if the block does not fit the image.
  void merge(const RowBlock& block);

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] const std::vector<PixelSums>& pixels() const { return pixels_; }  ///< by image row
  /// Samples of each pixel that have come, excluded ones too.
  [[nodiscard]] const std::vector<std::uint32_t>& samples() const { return samples_; }
  /// By image row and column: samples that the pixel's sums do not hold. Empty as a rule.
  struct Excluded {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  using PixelAddress = std::pair<std::uint32_t, std::uint32_t>;
  [[nodiscard]] const std::map<PixelAddress, Excluded>& excluded() const { return excluded_; }
  [[nodiscard]] const TraceCounts& counts() const { return counts_; }
  [[nodiscard]] PictureState state(double largest_radiance) const {
    return {width_, height_, pixels_, samples_, largest_radiance};
  }

 private:
  std::uint32_t width_;
  std::uint32_t height_;
  std::vector<std::uint32_t> row_at_;
  std::vector<PixelSums> pixels_;
  std::vector<std::uint32_t> samples_;
  WorkRect pass_rect_;
  std::vector<SampleRange> pass_;  ///< of each pixel, image order; empty: pass_rect_'s
  std::map<PixelAddress, Excluded> excluded_;
  TraceCounts counts_;
};

}  // namespace parray
