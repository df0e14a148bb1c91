#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "common/base/arrays.h"
#include "common/image/cell_records.h"
#include "common/image/pixel_sums.h"
#include "common/image/sample_range.h"

namespace parray::image {

/// The state of a picture between two passes: a view, with pixels by image row. The picture's error
/// and its next pass are computed from it.
struct FramebufferView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const PixelSums> pixels;
  std::span<const std::uint32_t> counts;  ///< number of samples of each pixel, with excluded ones
  double largest_radiance = 1;  ///< of the scene: determines the RadianceScale of `pixels`
  double rays_per_sample = 1;   ///< average
};

/// The sums of a whole picture, and the number of samples of each pixel that they hold. Not
/// thread-safe.
class Framebuffer {
 public:
  /// Allocates 76 bytes per pixel. `large_pages` is faster unless few pixels get samples.
  Framebuffer(std::uint32_t width, std::uint32_t height, bool large_pages = true);

  /// Adds the sums of pixels (x, y), (x + step, y) ..., which hold `samples`. The caller guarantees
  /// that the framebuffer does not hold these samples yet. Throws std::logic_error for pixels
  /// outside the image.
  void add(std::uint32_t y, std::uint32_t x, std::span<const PixelSums> sums,
           const RunSamples& samples, std::uint32_t step = 1);
  /// Adds to counts(), which the call above leaves as they are.
  void add(const TraceCounts& counts) { counts_ += counts; }
  /// Prefetches the memory of pixel (x, y) and of some pixels right of it, which the caller will
  /// add to next.
  void expect(std::uint32_t y, std::uint32_t x) const;
  /// Makes the system provide part `part` of the memory, 0 .. `parts` - 1, now. Otherwise the
  /// system provides it when a pixel gets its first sample, and that sample seems slow. Different
  /// threads may touch different parts at the same time.
  void touch(std::size_t part, std::size_t parts);
  static constexpr std::size_t pixel_bytes = sizeof(PixelSums) + sizeof(std::uint32_t);
  /// Notes samples that are in the count of a pixel but not in its sums. Throws std::logic_error
  /// for a pixel outside the image.
  void exclude(const ExcludedSamples& samples);

  /// Removes all samples of pixels [x_begin, x_end) of row y, or of every `step`-th of them. The
  /// pixels must lie in the image. Subtracts `counts`, those of the removed samples, from counts().
  void clear(std::uint32_t y, std::uint32_t x_begin, std::uint32_t x_end, const TraceCounts& counts,
             std::uint32_t step = 1);

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  [[nodiscard]] std::span<const PixelSums> pixels() const { return pixels_.view(); }  ///< by row
  /// Returns the number of samples of each pixel, including excluded ones.
  [[nodiscard]] std::span<const std::uint32_t> samples() const { return samples_.view(); }
  /// Returns whether every pixel has a sample.
  [[nodiscard]] bool whole() const { return untouched_ == 0; }
  /// Samples that are missing from a pixel's sums.
  struct Excluded {
    std::uint32_t first = 0;  ///< number of the first of them
    std::uint32_t count = 0;
  };
  using PixelAddress = std::pair<std::uint32_t, std::uint32_t>;  ///< image row, column
  /// Returns the excluded samples of each pixel that has some. Usually empty.
  [[nodiscard]] const std::map<PixelAddress, Excluded>& excluded() const { return excluded_; }
  [[nodiscard]] const TraceCounts& counts() const { return counts_; }
  /// Returns a view of this object. `largest_radiance`: that of the scene.
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
