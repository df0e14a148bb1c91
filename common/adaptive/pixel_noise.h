#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"

namespace parray::adaptive {

/// The noise of a pixel, from its own samples, by channel.
struct PixelNoise {
  std::array<double, 3> mean{};  ///< radiance
  /// Unbiased variance of one sample, in squared radiance; >= 0.
  std::array<double, 3> variance{};
  /// Difference between the means of the two replicates (even and odd samples), in radiance. It is
  /// scaled so that its mean square equals that of the error of the pixel's mean, with any sampler.
  std::array<double, 3> difference{};
};

/// Returns the noise of a pixel with `count` samples; zeros if `count` is less than 2. The
/// replicates A and B have a and b samples, and the difference is (A - B) sqrt(ab) / (a + b). With
/// a = b it is half of A - B, and the error of the mean is half of the sum of both errors. The
/// result has the same bits on every machine.
PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale);

// Views of rows of pixels, 3 values (R, G, B) per pixel.

/// PixelNoise of a row, and for each value the number of samples of its pixel. The spans are
/// equally long.
struct NoiseRow {
  std::span<const double> count;
  std::span<const double> mean;
  std::span<const double> variance;
  std::span<const double> difference;
};

/// The noise around each pixel of a row, from the samples of other pixels. A pixel's own samples
/// are left out: their chance errors must not influence how many samples the pixel gets.
struct NeighbourhoodRow {
  std::span<const double> mean;  ///< mean variance; see NeighbourhoodSize
  /// The largest variance that two opposite neighbours of the pixel both reach. It is high on an
  /// edge in the picture, and low beside the edge.
  std::span<const double> ridge;
  // Only with NeighbourhoodSize::windows.
  std::span<const double> radiance;  ///< mean radiance of the up to 8 neighbours
  /// A number of bright samples: if so many of the 8 neighbours' samples had the largest radiance
  /// and the others were black, the variance would be `mean`. It counts as if the neighbours had
  /// the average number of samples of the far window. So it is nearly independent of the pixel's
  /// own samples.
  std::span<const double> seen;
};

/// The noise of a row's pixels and of their surroundings.
struct NoiseNearby {
  NoiseRow own;
  NeighbourhoodRow around;
};

/// Means over a square around each pixel of a row, cut at the border. Rows have rounded()
/// variances, so that all sums are exact. So a mean without the pixel itself contains nothing of
/// that pixel.
class NoiseWindow {
 public:
  /// Values of a row, 4 per pixel: variances by channel, in units of the largest radiance squared,
  /// and the number of samples.
  using Row = std::span<const double>;
  /// Returns `variance` rounded to a multiple of 2^-38.
  static double rounded(double variance) { return (variance + 0x1p14) - 0x1p14; }

  /// For squares of 2 * reach + 1 pixels a side, in rows of `width` pixels.
  NoiseWindow(std::size_t reach, std::size_t width);
  /// Moves the window to row y of `height`; y must not decrease. `row_at(y)` returns a Row. The
  /// window asks for rows from y - 3 * reach - 1 on, and for no row that comes 2 * reach + 2 or
  /// more rows before the last one that it asked for.
  void move_to(std::size_t y, std::size_t height, auto&& row_at) {
    const std::size_t first = y - std::min(y, reach_);
    if (first >= end_) {
      columns_.assign(columns_.size(), 0);
      first_ = end_ = first;
    }
    for (; end_ < std::min(y + reach_ + 1, height); ++end_) {
      if (end_ - first_ > 2 * reach_) add(row_at(first_++), -1);
      add(row_at(end_), 1);
    }
    while (first_ < first) add(row_at(first_++), -1);
  }
  /// Computes, for each pixel of the row, means over the other pixels of its square. `own` must be
  /// the row itself. Writes mean variances (in the unit of a Row) and mean numbers of samples, 3
  /// values per pixel each.
  void means(Row own, std::span<double> variances, std::span<double> samples);

 private:
  void add(Row row, double sign);

  std::size_t reach_;
  std::size_t width_;
  /// Sums over rows first_ .. end_ - 1, 4 per pixel; zeros beyond both ends of the row.
  std::vector<double> columns_;
  std::vector<double> others_;  ///< 3 per pixel: number of other pixels in the window around it
  std::size_t first_ = 0;
  std::size_t end_ = 0;
};

/// The reach of NeighbourhoodRow.mean.
enum class NeighbourhoodSize : std::uint8_t {
  /// The 8 neighbours.
  neighbours,
  /// The mean of the 8 neighbours, mixed with that of wider windows. The fewer bright samples the
  /// neighbours show, the larger is the weight of the wider windows. The 8 neighbours alone
  /// sometimes give 0 and sometimes far too much, if bright samples are rare. Samples would then go
  /// where noise was found by chance, and a pixel's own chance errors would influence its number of
  /// samples in the end. For the same reason the result does not depend on the number of samples of
  /// the 8 neighbours.
  windows,
};

/// Computes NoiseNearby for the rows of a picture. The 8 neighbours of a pixel are mirrored at the
/// border. In a picture of one row or column, a pixel is its own neighbour. Keeps at most 34 rows
/// in memory.
class NoiseRows {
 public:
  /// Keeps a view of `state`.
  NoiseRows(const FramebufferView& state, NeighbourhoodSize horizon);
  /// Returns the noise of row y, which must be larger than in the previous call. The result is
  /// valid until the next call.
  NoiseNearby row(std::size_t y);
  /// Returns the `own` part of row(y), and computes nothing else. y must not decrease.
  NoiseRow own(std::size_t y);

 private:
  static constexpr std::size_t near = 4;  ///< reach of the windows
  static constexpr std::size_t far = 16;
  using Values = std::vector<double>;
  struct Kept {
    // Each includes the mirrored pixels at both ends.
    Values count;
    Values mean;
    Values variance;
    Values difference;
    Values rounded;  ///< NoiseWindow::Row
  };

  void keep_rows_until(std::size_t y);
  void keep(std::size_t y);
  [[nodiscard]] Kept& kept(std::size_t y) { return kept_[y % kept_.size()]; }
  void look_around(std::size_t y);
  void look_afar(std::size_t y);

  FramebufferView state_;
  bool windows_;
  std::size_t reach_;
  RadianceScale scale_;
  double unit_;  ///< of variance: the largest radiance squared
  std::vector<Kept> kept_;
  std::size_t have_ = 0;  ///< next row to keep; earlier rows were kept or skipped
  NoiseWindow near_;
  NoiseWindow far_;
  Values close_by_;
  Values far_off_;
  Values samples_;  ///< mean of the far window
  Values mean_;
  Values ridge_;
  Values radiance_;
  Values seen_;
};

/// Rows of a picture that one thread processes. The number of bands depends on the picture alone.
/// So sums of each band, added in the order of the bands, have the same bits for any number of
/// threads.
struct NoiseBand {
  std::size_t number = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
  /// Returns the first row of the band among every `stride`-th row of the picture.
  [[nodiscard]] std::size_t first(std::size_t stride) const {
    return (begin + stride - 1) / stride * stride;
  }
};
/// Returns the number of bands of a picture with `height` rows.
std::size_t noise_bands(std::size_t height);
/// Calls work(NoiseBand) for all bands on `threads` threads; 0: as many as OpenMP gives the caller.
/// Rethrows an exception of one of them.
void for_noise_bands(std::size_t height, int threads,
                     const std::function<void(const NoiseBand&)>& work);
/// Returns the number of threads for reading every `stride`-th row; 0: as many as OpenMP gives. Few
/// rows are read sooner than threads start.
inline int noise_threads(std::size_t stride) { return stride > 4 ? 1 : 0; }

/// Calls visit(band's number, y, NoiseNearby) for every `stride`-th row, in order within a band.
/// Rows of different bands are visited at the same time by different threads.
void visit_noise(const FramebufferView& state, std::size_t stride, NeighbourhoodSize horizon,
                 auto&& visit) {
  for_noise_bands(state.height, noise_threads(stride), [&](const NoiseBand& band) {
    NoiseRows rows(state, horizon);
    for (std::size_t y = band.first(stride); y < band.end; y += stride) {
      visit(band.number, y, rows.row(y));
    }
  });
}

}  // namespace parray::adaptive
