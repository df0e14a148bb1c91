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

/// What a pixel's own samples say about its noise, by channel.
struct PixelNoise {
  std::array<double, 3> mean{};  ///< radiance
  /// Of one sample, unbiased, in squared radiance; >= 0.
  std::array<double, 3> variance{};
  /// Of the means of the two replicates, scaled so that its mean square is that of the error of the
  /// pixel's mean, whatever the sampler; in radiance.
  std::array<double, 3> difference{};
};

/// Of a pixel with `count` samples; zeros if less than 2. The replicates A and B have a and b
/// samples, and the difference is (A - B) sqrt(ab) / (a + b): with a = b, half of A - B, where the
/// error of the mean is half of the sum of theirs. Arithmetic that is the same everywhere.
PixelNoise noise_of(const PixelSums& pixel, std::uint32_t count, const RadianceScale& scale);

// Of rows of pixels, 3 values (R, G, B) a pixel. Views.

/// PixelNoise, and the number of samples of the value's pixel.
struct NoiseRow {
  std::span<const double> count;
  std::span<const double> mean;
  std::span<const double> variance;
  std::span<const double> difference;
};

/// What the pixels around a pixel say about its noise: all that can be known of it without asking
/// its own samples, whose luck would decide the answer.
struct NeighbourhoodRow {
  std::span<const double> mean;  ///< variance; see NeighbourhoodSize
  /// The largest variance that two opposite neighbours reach: high on an edge, low beside it.
  std::span<const double> ridge;
  // Only with NeighbourhoodSize::windows.
  std::span<const double> radiance;  ///< mean of the up to 8 next to it
  /// How many samples of the largest radiance that variance would take in the 8, had they as many
  /// samples as the pixels of the window. Independent of the pixel's own, nearly.
  std::span<const double> seen;
};

struct NoiseNearby {
  NoiseRow own;
  NeighbourhoodRow around;
};

/// Means over a square around each pixel of a row, cut at the border. Variances are rounded so that
/// all sums are exact, and one without its own pixel knows nothing of that.
class NoiseWindow {
 public:
  /// Values of a row, 4 a pixel: variances by channel, in units of the largest radiance squared,
  /// and the number of samples.
  using Row = std::span<const double>;
  static double rounded(double variance) { return (variance + 0x1p14) - 0x1p14; }

  NoiseWindow(std::size_t reach, std::size_t width);
  /// Makes it a window around row y of `height`; y must not fall. `row_at(y)`: Row; asks for rows
  /// y - 3 * reach - 1 and on, none as much as 2 * reach + 2 rows above the last one.
  template <typename RowAt>
  void move_to(std::size_t y, std::size_t height, RowAt&& row_at) {
    const std::size_t first = y - std::min(y, reach_);
    if (first >= end_) {
      columns_.assign(columns_.size(), 0);
      first_ = end_ = first;
    }
    for (; end_ < std::min(y + reach_ + 1, height); ++end_) {
      if (end_ - first_ > 2 * reach_) {
        add(row_at(first_++), -1);
      }
      add(row_at(end_), 1);
    }
    while (first_ < first) {
      add(row_at(first_++), -1);
    }
  }
  /// Means over the windows around the row's pixels without these, which are `own`: of variances
  /// and of samples, 3 values a pixel each.
  void means(Row own, std::span<double> variances, std::span<double> samples);

 private:
  void add(Row row, double sign);

  std::size_t reach_;
  std::size_t width_;
  /// Sums over rows first_ .. end_ - 1, 4 a pixel; nothing beyond both ends of the row.
  std::vector<double> columns_;
  std::vector<double> others_;  ///< 3 a pixel: how many are in the window around it
  std::size_t first_ = 0;
  std::size_t end_ = 0;
};

/// How far NeighbourhoodRow.mean looks.
enum class NeighbourhoodSize : std::uint8_t {
  /// To the 8 pixels next to it.
  neighbours,
  /// That of the 8, mixed with that of wider windows by as much as the 8 may have missed. Where few
  /// bright samples are seen, an estimate of the 8 alone is 0 or far too high by turns: it would
  /// send samples after luck, more of them where that shows more, and so tell a pixel of its own
  /// luck in the end. Nor does it matter how many samples the 8 have: that, too, would tell.
  windows,
};

/// NoiseNearby of a picture's rows. The 8 next to a pixel are mirrored at the border.
/// Memory: some 40 rows.
class NoiseRows {
 public:
  /// A view of `state`.
  NoiseRows(const FramebufferView& state, NeighbourhoodSize horizon);
  /// Of row y, which is below the last one asked for. Valid until the next call.
  NoiseNearby row(std::size_t y);
  /// The same without what is around.
  NoiseRow own(std::size_t y);

 private:
  static constexpr std::size_t near = 4;  ///< reach of the windows
  static constexpr std::size_t far = 16;
  using Values = std::vector<double>;
  struct Kept {
    // With the mirrored pixels of either end.
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
  std::size_t have_ = 0;  ///< rows above this one are kept, or were
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

/// Rows of a picture that one thread goes through. How many bands there are depends on the picture
/// alone: sums over each, added up in their order, have the same bits for any number of threads.
struct NoiseBand {
  std::size_t number = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
  /// The first of every `stride`-th row of the picture.
  [[nodiscard]] std::size_t first(std::size_t stride) const {
    return (begin + stride - 1) / stride * stride;
  }
};
std::size_t noise_bands(std::size_t height);
/// Calls work(NoiseBand) for all bands, on `threads`, 0: as many as OpenMP gives the caller. Throws
/// what one of them has thrown.
void for_noise_bands(std::size_t height, int threads,
                     const std::function<void(const NoiseBand&)>& work);
/// For every `stride`-th row: some rows are read sooner than threads begin.
inline int noise_threads(std::size_t stride) { return stride > 4 ? 1 : 0; }

/// Calls visit(band's number, y, NoiseNearby) for every `stride`-th row, in order within a band.
template <typename Visit>
void visit_noise(const FramebufferView& state, std::size_t stride, NeighbourhoodSize horizon,
                 Visit&& visit) {
  for_noise_bands(state.height, noise_threads(stride), [&](const NoiseBand& band) {
    NoiseRows rows(state, horizon);
    for (std::size_t y = band.first(stride); y < band.end; y += stride) {
      visit(band.number, y, rows.row(y));
    }
  });
}

}  // namespace parray::adaptive
