#include "cli/output/denoise/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "cli/output/denoise/filter_kernel.h"
#include "common/adaptive/noise_model.h"
#include "common/math/float_mode.h"
#include "common/trace/isa.h"

namespace parray::denoise {
namespace {

// Windows of the kernels must stay inside the margin.
static_assert(Plane::margin >= filter_reach + patch_reach);
static_assert(Plane::tile % tile_width == 0 && Plane::tile % tile_height == 0);
static_assert(filter_features == feature_count);

using Radiance = std::vector<Plane>;  ///< R, G, B

/// A half with each degree of smoothing.
using Grades = std::array<Radiance, filter_grades>;

Radiance radiance_planes(std::uint32_t width, std::uint32_t height) {
  return {3, Plane(width, height)};
}

/// Returns a power of two, so that scaling rounds nothing. It brings the picture's largest value to
/// 1 .. 2. Then all squares fit the range of a float.
float scale_of(const Replicates& replicates) {
  float most = 0;
  for (const std::vector<float>& mean : replicates.mean) {
    for (const float value : mean) most = std::max(most, value);
  }
  int exponent = 0;
  std::frexp(most, &exponent);
  return most > 0 ? std::ldexp(1.0F, std::clamp(1 - exponent, -120, 120)) : 1.0F;
}

void (*filter_for(Isa isa))(const FilterPlanes&, int, int, float*) {
  switch (isa == Isa::automatic ? best_isa() : isa) {
#define PARRAY_FILTER_OF(isa) \
  case Isa::isa: return isa::filter_tile;
    PARRAY_FOR_EACH_ISA(PARRAY_FILTER_OF)
#undef PARRAY_FILTER_OF
    default: return scalar::filter_tile;
  }
}

/// Sums of products of the differences from a coarse picture to a fine picture, a raw picture and a
/// goal. They give the mixture of the three pictures that is closest to the goal.
class Agreement {
 public:
  void add(double fine, double raw, double goal) {
    fine_fine_ += fine * fine;
    fine_raw_ += fine * raw;
    raw_raw_ += raw * raw;
    fine_goal_ += fine * goal;
    raw_goal_ += raw * goal;
  }
  Agreement& operator+=(const Agreement& other) { return add_times(1, other); }
  Agreement& operator-=(const Agreement& other) { return add_times(-1, other); }

  struct Shares {
    double fine = 0;
    double raw = 0;
  };
  /// Returns the shares of fine and raw. Neither is negative, and their sum is at most 1.
  [[nodiscard]] Shares shares() const {
    const double determinant = fine_fine_ * raw_raw_ - fine_raw_ * fine_raw_;
    if (determinant > 1e-9 * fine_fine_ * raw_raw_) {
      const Shares inside{(fine_goal_ * raw_raw_ - raw_goal_ * fine_raw_) / determinant,
                          (raw_goal_ * fine_fine_ - fine_goal_ * fine_raw_) / determinant};
      if (inside.fine >= 0 && inside.raw >= 0 && inside.fine + inside.raw <= 1) return inside;
    }
    // Otherwise the best mixture lies on an edge of the triangle.
    const double between = fine_fine_ - 2 * fine_raw_ + raw_raw_;
    const double from_raw = share(fine_goal_ - raw_goal_ - fine_raw_ + raw_raw_, between);
    const std::array<Shares, 3> edges{{{share(fine_goal_, fine_fine_), 0},
                                       {0, share(raw_goal_, raw_raw_)},
                                       {from_raw, 1 - from_raw}}};
    return *std::ranges::min_element(edges, {}, [this](const Shares& at) { return excess(at); });
  }

 private:
  Agreement& add_times(double sign, const Agreement& other) {
    fine_fine_ += sign * other.fine_fine_;
    fine_raw_ += sign * other.fine_raw_;
    raw_raw_ += sign * other.raw_raw_;
    fine_goal_ += sign * other.fine_goal_;
    raw_goal_ += sign * other.raw_goal_;
    return *this;
  }
  static double share(double way, double square) {
    return square > 0 ? std::clamp(way / square, 0.0, 1.0) : 0.0;
  }
  /// Returns the square distance from the goal, except for a constant.
  [[nodiscard]] double excess(const Shares& at) const {
    return at.fine * at.fine * fine_fine_ + 2 * at.fine * at.raw * fine_raw_ +
           at.raw * at.raw * raw_raw_ - 2 * (at.fine * fine_goal_ + at.raw * raw_goal_);
  }

  double fine_fine_ = 0;
  double fine_raw_ = 0;
  double raw_raw_ = 0;
  double fine_goal_ = 0;
  double raw_goal_ = 0;
};

/// Filters a picture.
class Denoiser {
 public:
  Denoiser(const Replicates& replicates, const Features& features, int threads, Isa isa,
           const std::function<void()>& between_bands)
      : replicates_(replicates),
        features_(features),
        threads_(threads),
        filter_(filter_for(isa)),
        between_bands_(between_bands),
        scale_(scale_of(replicates)),
        noise_(features.steady[0].width(), features.steady[0].height()),
        width_(noise_.width()),
        height_(noise_.height()) {
    for (std::uint32_t y = 0; y < height_; ++y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        const float rmse = replicates.noise[std::size_t{y} * width_ + x] * scale_;
        noise_.row(y)[x] = rmse * rmse;
      }
    }
    noise_.repeat_border();
    for (const std::size_t half : {0U, 1U}) halves_[half] = half_planes(half);
  }

  Denoised run() {
    std::array<Radiance, 2> clean{filtered(0), filtered(1)};
    return result(clean[0], clean[1]);
  }

 private:
  [[nodiscard]] Radiance half_planes(std::size_t half) const {
    Radiance planes = radiance_planes(width_, height_);
    const float* value = replicates_.mean[half].data();
    for (std::uint32_t y = 0; y < height_; ++y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        for (Plane& plane : planes) plane.row(y)[x] = *value++ * scale_;
      }
    }
    for (Plane& plane : planes) plane.repeat_border();
    return planes;
  }

  /// Returns a half with each degree of smoothing.
  [[nodiscard]] Grades smoothed(std::size_t half) const {
    Grades grades{radiance_planes(width_, height_), radiance_planes(width_, height_)};
    const char* const plain = features_.plain_sky.empty() ? nullptr : features_.plain_sky.data();
    FilterPlanes planes{.width = static_cast<int>(width_),
                        .height = static_cast<int>(height_),
                        .stride = static_cast<std::ptrdiff_t>(noise_.stride()),
                        .noise = noise_.row(0),
                        .plain = plain};
    for (std::size_t c = 0; c < 3; ++c) {
      planes.radiance[c] = halves_[half][c].row(0);
      for (std::size_t grade = 0; grade < filter_grades; ++grade) {
        planes.out[grade][c] = grades[grade][c].row(0);
      }
    }
    for (std::size_t f = 0; f < feature_count; ++f) {
      planes.own[f] = features_.own[half][f].row(0);
      planes.steady[f] = features_.steady[f].row(0);
    }
    filter_tiles(planes);
    return grades;
  }

  void filter_tiles(const FilterPlanes& planes) const {
    const int across = (planes.width + tile_width - 1) / tile_width;
    const int down = (planes.height + tile_height - 1) / tile_height;
    const int band = std::max(2 * threads_ / across, 1);
    for (int begin = 0; begin < down; begin += band) {
      if (between_bands_) between_bands_();
      const int count = std::min(band, down - begin) * across;
#pragma omp parallel num_threads(threads_)
      {
        const FloatMode ieee;
        std::vector<float> scratch(filter_scratch);
#pragma omp for schedule(dynamic) nowait
        for (int i = 0; i < count; ++i) {
          filter_(planes, i % across * tile_width, (begin + i / across) * tile_height,
                  scratch.data());
        }
      }
    }
  }

  [[nodiscard]] Radiance filtered(std::size_t half) const {
    Grades grades = smoothed(half);
    mix(grades, halves_[half], halves_[1 - half]);
    return std::move(grades.back());
  }

  /// Replaces the coarser grade by the mixture of the coarser grade, the finer grade and the half.
  /// The mixture is closest to `other` in the pixels around each pixel, without the pixel itself.
  void mix(Grades& grades, const Radiance& half, const Radiance& other) const {
    std::vector<Agreement> agreements(std::size_t{width_} * height_);
#pragma omp parallel num_threads(threads_)
    {
      const FloatMode ieee;
#pragma omp for
      for (std::size_t y = 0; y < height_; ++y) {
        agree_row(y, grades, half, other, std::span(agreements).subspan(y * width_, width_));
      }
#pragma omp for
      for (std::size_t y = 0; y < height_; ++y) mix_row(y, agreements, half, grades);
    }
  }

  static void agree_row(std::size_t y, const Grades& grades, const Radiance& half,
                        const Radiance& other, std::span<Agreement> agreements) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const coarse = grades[1][c].row(y);
      const float* const fine = grades[0][c].row(y);
      const float* const raw = half[c].row(y);
      const float* const goal = other[c].row(y);
      for (std::size_t x = 0; x < agreements.size(); ++x) {
        const double from = coarse[x];
        agreements[x].add(fine[x] - from, raw[x] - from, goal[x] - from);
      }
    }
  }

  void mix_row(std::size_t y, const std::vector<Agreement>& agreements, const Radiance& half,
               Grades& grades) const {
    constexpr std::size_t reach = 6;
    const std::size_t width = width_;
    const std::size_t first = y - std::min(y, reach);
    const std::size_t end = std::min<std::size_t>(y + reach + 1, height_);
    std::vector<Agreement> columns(width);
    for (std::size_t row = first; row < end; ++row) {
      for (std::size_t x = 0; x < width; ++x) columns[x] += agreements[row * width + x];
    }
    for (std::size_t x = 0; x < width; ++x) {
      Agreement around;
      for (std::size_t at = x - std::min(x, reach); at < std::min(x + reach + 1, width); ++at) {
        around += columns[at];
      }
      around -= agreements[y * width + x];
      const auto [fine, raw] = around.shares();
      for (std::size_t c = 0; c < 3; ++c) {
        float* const value = grades[1][c].row(y) + x;
        const float from = *value;
        *value += static_cast<float>(fine) * (grades[0][c].row(y)[x] - from) +
                  static_cast<float>(raw) * (half[c].row(y)[x] - from);
      }
    }
  }

  /// Returns the mean of both halves and its error by the identity in denoise.h.
  [[nodiscard]] Denoised result(const Radiance& f, const Radiance& g) const {
    Denoised out;
    out.rgb.resize(3 * std::size_t{width_} * height_);
    double square = 0;
    double scatter = 0;  // of the terms with mean 0, with D instead of the truth
    float* value = out.rgb.data();
    for (std::uint32_t y = 0; y < height_; ++y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        double noise = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const double a = halves_[0][c].row(y)[x];
          const double b = halves_[1][c].row(y)[x];
          const double fa = f[c].row(y)[x];
          const double gb = g[c].row(y)[x];
          const double d = (fa + gb) / 2;
          square += ((fa - b) * (fa - b) + (gb - a) * (gb - a) - (a - b) * (a - b)) / 2 -
                    (fa - gb) * (fa - gb) / 4;
          noise += (a - d) * (b - d) - (fa - d) * (b - d) - (gb - d) * (a - d);
          *value++ = static_cast<float>(d / scale_);
        }
        scatter += noise * noise;
      }
    }
    const double values = static_cast<double>(out.rgb.size());
    // With D instead of the truth, a raw pixel has (A - B)^2 / 4 for a product of two errors. The
    // mean square of that product is 3/4 of this value.
    constexpr double least_seen = 0.75;
    const double half_width = normal_95 * std::sqrt(scatter / least_seen);
    const auto rmse_of = [&](double sum) {
      return std::sqrt(std::max(sum, 0.0) / values) / scale_;
    };
    out.rmse = rmse_of(square);
    out.low = rmse_of(square - half_width);
    out.high = rmse_of(std::max(square, 0.0) + half_width);
    return out;
  }

  const Replicates& replicates_;
  const Features& features_;
  int threads_;
  void (*filter_)(const FilterPlanes&, int, int, float*);
  const std::function<void()>& between_bands_;
  float scale_;
  Plane noise_;
  std::uint32_t width_;
  std::uint32_t height_;
  std::array<Radiance, 2> halves_;
};

}  // namespace

Denoised denoise(const Replicates& replicates, const Features& features, int threads, Isa isa,
                 const std::function<void()>& between_bands) {
  return Denoiser(replicates, features, threads, isa, between_bands).run();
}

}  // namespace parray::denoise
