#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "common/base/zeroed_array.h"
#include "common/image/cell_records.h"
#include "common/image/pixel_sums.h"
#include "common/image/sample_range.h"

namespace parray::image {

/// What is known of an image between two passes. A view; pixels by image row.
struct FramebufferView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const PixelSums> pixels;
  std::span<const std::uint32_t> counts;  ///< samples of each pixel: 0 .. counts - 1
  double largest_radiance = 1;
  double rays_per_sample = 1;  ///< on average
};

/// The sums of a whole image, and how many samples of each pixel they hold.
/// Plain state; one thread at a time.
class Framebuffer {
 public:
  /// 76 bytes a pixel. `large_pages`: pays unless few pixels are to have samples.
  Framebuffer(std::uint32_t width, std::uint32_t height, bool large_pages = true);

  /// Adds sums of pixels (x, y), (x + step, y) ..., which hold `samples`. The caller vouches that
  /// these are not in yet. Throws std::logic_error beyond the image.
  void add(std::uint32_t y, std::uint32_t x, std::span<const PixelSums> sums,
           const RunSamples& samples, std::uint32_t step = 1);
  /// The same with a range for each; also throws where there are not as many ranges as sums.
  void add(std::uint32_t y, std::uint32_t x, std::span<const PixelSums> sums,
           std::span<const SampleRange> ranges);
  void add(const TraceCounts& counts) { counts_ += counts; }
  /// Pixel (x, y) of the image and some right of it will be added to next: fetches their memory.
  void expect(std::uint32_t y, std::uint32_t x) const;
  /// Has the system provide a part of the memory now, `part` of 0 .. `parts` - 1, and not when a
  /// pixel gets its first sample, which then seems to take long. A thread for each part, if need
  /// be.
  void touch(std::size_t part, std::size_t parts);
  static constexpr std::size_t pixel_bytes = sizeof(PixelSums) + sizeof(std::uint32_t);
  /// Samples that were added to the count of a pixel, but are not in its sums.
  void exclude(const ExcludedSamples& samples);

  /// Pixels [x_begin, x_end) of row y, or every `step`-th of them, have no samples any more;
  /// `counts` are those of the work behind theirs.
  void clear(std::uint32_t y, std::uint32_t x_begin, std::uint32_t x_end, const TraceCounts& counts,
             std::uint32_t step = 1);

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] std::span<const PixelSums> pixels() const { return pixels_.view(); }  ///< by row
  /// Samples of each pixel that have come, excluded ones too.
  [[nodiscard]] std::span<const std::uint32_t> samples() const { return samples_.view(); }
  /// Whether every pixel has a sample.
  [[nodiscard]] bool whole() const { return untouched_ == 0; }
  /// By image row and column: samples that the pixel's sums do not hold. Empty as a rule.
  struct Excluded {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  using PixelAddress = std::pair<std::uint32_t, std::uint32_t>;
  [[nodiscard]] const std::map<PixelAddress, Excluded>& excluded() const { return excluded_; }
  [[nodiscard]] const TraceCounts& counts() const { return counts_; }
  [[nodiscard]] FramebufferView view(double largest_radiance) const {
    const auto traced = static_cast<double>(counts_.samples > 0 ? counts_.samples : 1);
    return {width_,    height_,          pixels(),
            samples(), largest_radiance, static_cast<double>(counts_.rays) / traced};
  }

 private:
  std::uint32_t width_;
  std::uint32_t height_;
  ZeroedArray<PixelSums> pixels_;
  ZeroedArray<std::uint32_t> samples_;
  std::uint64_t untouched_;  ///< pixels without a sample
  std::map<PixelAddress, Excluded> excluded_;
  TraceCounts counts_;
};

}  // namespace parray::image
