#include "common/denoise/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "common/adaptive/noise_model.h"
#include "common/denoise/filter_kernel.h"
#include "common/math/float_mode.h"
#include "common/trace/isa.h"

namespace parray {
namespace {

using Radiance = std::vector<Plane>;  ///< R, G, B

/// What a half becomes with the degrees of smoothing.
using Grades = std::array<Radiance, filter_grades>;

Radiance radiance_planes(std::uint32_t width, std::uint32_t height) {
  return {3, Plane(width, height)};
}

/// Of two, so that nothing is rounded: brings the picture's largest value to 1 .. 2, and with it
/// all squares into the range of a float.
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
#if defined(__x86_64__)
    case Isa::avx512:
      return avx512::filter_tile;
    case Isa::avx2:
      return avx2::filter_tile;
#endif
    default:
      return scalar::filter_tile;
  }
}

/// Filters one picture.
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

  /// A half with each degree of smoothing.
  [[nodiscard]] Grades smoothed(std::size_t half) const {
    Grades grades{radiance_planes(width_, height_), radiance_planes(width_, height_)};
    FilterPlanes planes{.width = static_cast<int>(width_),
                        .height = static_cast<int>(height_),
                        .stride = static_cast<std::ptrdiff_t>(noise_.stride()),
                        .noise = noise_.row(0)};
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
    const Radiance& other = halves_[1 - half];
    Radiance& mixture = grades.back();
    for (std::size_t grade = filter_grades - 1; grade-- > 0;) {
      mix_towards(grades[grade], other, mixture);
    }
    mix_towards(halves_[half], other, mixture);
    for (std::size_t i = 0; i < features_.plain_sky.size(); ++i) {
      if (features_.plain_sky[i] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        mixture[c].row(i / width_)[i % width_] = halves_[half][c].row(i / width_)[i % width_];
      }
    }
    return std::move(mixture);
  }

  /// Goes from `mixture` towards `finer` as far as brings the pixels around, but not in it, closest
  /// to `other`: the projection of other - mixture upon finer - mixture, 0 to 1 of it.
  void mix_towards(const Radiance& finer, const Radiance& other, Radiance& mixture) const {
    const std::size_t width = width_;
    const std::size_t height = height_;
    std::vector<double> along(width * height);
    std::vector<double> squares(width * height);
#pragma omp parallel num_threads(threads_)
    {
      const FloatMode ieee;
#pragma omp for
      for (std::size_t y = 0; y < height; ++y) {
        project_row(y, finer, other, mixture, std::span(along).subspan(y * width, width),
                    std::span(squares).subspan(y * width, width));
      }
#pragma omp for
      for (std::size_t y = 0; y < height; ++y) {
        mix_row(y, along, squares, finer, mixture);
      }
    }
  }

  static void project_row(std::size_t y, const Radiance& finer, const Radiance& other,
                          const Radiance& mixture, std::span<double> along,
                          std::span<double> squares) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const from = mixture[c].row(y);
      const float* const to = finer[c].row(y);
      const float* const goal = other[c].row(y);
      for (std::size_t x = 0; x < along.size(); ++x) {
        const double way = static_cast<double>(to[x]) - from[x];
        along[x] += way * (static_cast<double>(goal[x]) - from[x]);
        squares[x] += way * way;
      }
    }
  }

  void mix_row(std::size_t y, const std::vector<double>& along, const std::vector<double>& squares,
               const Radiance& finer, Radiance& mixture) const {
    constexpr std::size_t reach = 6;
    const std::size_t width = width_;
    const std::size_t first = y - std::min(y, reach);
    const std::size_t end = std::min<std::size_t>(y + reach + 1, height_);
    std::vector<double> columns(2 * width);
    for (std::size_t row = first; row < end; ++row) {
      for (std::size_t x = 0; x < width; ++x) {
        columns[x] += along[row * width + x];
        columns[width + x] += squares[row * width + x];
      }
    }
    for (std::size_t x = 0; x < width; ++x) {
      double way = -along[y * width + x];
      double square = -squares[y * width + x];
      for (std::size_t at = x - std::min(x, reach); at < std::min(x + reach + 1, width); ++at) {
        way += columns[at];
        square += columns[width + at];
      }
      const double share = square > 0 ? std::clamp(way / square, 0.0, 1.0) : 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        float* const value = mixture[c].row(y) + x;
        *value += static_cast<float>(share) * (finer[c].row(y)[x] - *value);
      }
    }
  }

  /// The mean of both halves, and its error by the identity of denoise.h.
  [[nodiscard]] Denoised result(const Radiance& f, const Radiance& g) const {
    Denoised out;
    out.rgb.resize(3 * std::size_t{width_} * height_);
    double square = 0;
    double scatter = 0;  // of the terms whose mean is 0, by D in the place of the truth
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
    const double half_width = normal_95 * std::sqrt(scatter);
    const auto rmse_of = [&](double sum) {
      return std::sqrt(std::max(sum, 0.0) / values) / scale_;
    };
    out.rmse = rmse_of(square);
    out.low = rmse_of(square - half_width);
    out.high = rmse_of(square + half_width);
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

}  // namespace parray
