#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/image/row_block.h"
#include "common/scene/settings.h"

namespace parray {

/// The sums of a whole image, and how many samples of each row they hold.
/// Plain state; one thread at a time.
class Framebuffer {
 public:
  /// Sizes and row order from settings that resolve_settings() has completed.
  explicit Framebuffer(const RenderSettings& settings);

  /// Adds a block. The caller vouches that its samples are not in yet (LeaseTable does).
  /// Throws std::logic_error if the block does not fit the image.
  void merge(const RowBlock& block);

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] const std::vector<PixelSums>& pixels() const { return pixels_; }  ///< by image row
  [[nodiscard]] std::uint32_t samples_in_row(std::uint32_t row) const { return row_samples_[row]; }
  /// By image row and column: samples that the pixel's sums do not hold. Empty as a rule.
  struct Excluded {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  using PixelAddress = std::pair<std::uint32_t, std::uint32_t>;
  [[nodiscard]] const std::map<PixelAddress, Excluded>& excluded() const { return excluded_; }
  [[nodiscard]] const TraceCounts& counts() const { return counts_; }

 private:
  std::uint32_t width_;
  std::uint32_t height_;
  std::vector<std::uint32_t> row_at_;
  std::vector<PixelSums> pixels_;
  std::vector<std::uint32_t> row_samples_;
  std::map<PixelAddress, Excluded> excluded_;
  TraceCounts counts_;
};

}  // namespace parray
