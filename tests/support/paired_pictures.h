#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"

/// Pictures of one scene in two precisions, from the same random numbers.
namespace parray::test {

/// The difference of a picture from that of f64. Its unit is the Monte Carlo error (one standard
/// error) of f64's picture with `reference_samples` per pixel. It is the worst over all parts and
/// channels. Parts are blocks of 8 x 8 pixels, which have 8 times less noise than pixels, and the
/// whole picture. So parts reveal a bias that many pixels share, even if it is far below the noise
/// of a pixel.
struct PairedDifference {
  double least = 0;     ///< `found` minus 4 standard errors of the difference
  double found = 0;     ///< |mean difference|
  double standard = 0;  ///< largest standard error of a difference
};

class PairedPictures {
 public:
  static constexpr double reference_samples = 4096;
  static constexpr std::uint32_t block = 8;
  static constexpr std::uint32_t batch = 8;  ///< samples

  /// Width and height must be multiples of 8. `settings` has the other settings.
  PairedPictures(const Scene& scene, RenderSettings settings, Precision precision)
      : settings_(settings), scale_(largest_radiance(scene)) {
    settings.precision = precision;
    tracers_[0] = make_path_tracer(scene, settings);
    settings.precision = Precision::f64;
    tracers_[1] = make_path_tracer(scene, settings);
    exactly_.resize(std::size_t{settings.width} * settings.height);
    parts_.resize(3UL * (block_columns() * (settings.height / block) + 1));
    // Ignores differences of 8 roundings, which a picture in single precision cannot show.
    floor_ = 0x1p-21 * std::max(largest_radiance(scene), 1e-30);
  }

  [[nodiscard]] std::uint32_t samples() const { return samples_; }
  [[nodiscard]] std::uint64_t nonfinite() const { return counts_.nonfinite; }

  /// Traces this number of further samples of each pixel; a multiple of `batch`.
  void add(std::uint32_t samples) {
    for (const std::uint32_t end = samples_ + samples; samples_ < end; samples_ += batch) {
      std::vector<double> differences(parts_.size());
      for (std::uint32_t y = 0; y < settings_.height; ++y) add_row(y, differences);
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        parts_[i].sum += differences[i];
        parts_[i].square += differences[i] * differences[i];
      }
    }
  }

  [[nodiscard]] PairedDifference difference() const {
    const std::vector<double> noise = monte_carlo_errors();
    const double batches = samples_ / static_cast<double>(batch);
    PairedDifference worst;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const double mean = parts_[i].sum / batches;
      const double variance = std::max(parts_[i].square / batches - mean * mean, 0.0);
      const double unit = noise[i] + floor_;
      const double found = std::abs(mean) / unit;
      const double standard = std::sqrt(variance / (batches - 1)) / unit;
      worst.least = std::max(worst.least, found - 4 * standard);
      worst.found = std::max(worst.found, found);
      worst.standard = std::max(worst.standard, standard);
    }
    return worst;
  }

  /// Traces until it is clear whether the difference is less than the Monte Carlo error. Traces at
  /// least 256 samples, because their 32 batches are needed to know the standard error, and at most
  /// reference_samples.
  PairedDifference decide() {
    add(256);
    PairedDifference now = difference();
    while (now.least < 4 && now.found + 4 * now.standard > 1 && samples_ < reference_samples) {
      add(samples_);
      now = difference();
    }
    return now;
  }

 private:
  struct Part {
    double sum = 0;  ///< sum of the differences of batches
    double square = 0;
  };

  [[nodiscard]] std::size_t block_columns() const { return settings_.width / block; }

  void add_row(std::uint32_t y, std::vector<double>& differences) {
    const std::uint32_t width = settings_.width;
    std::vector<PixelSums> other(width);
    std::vector<PixelSums> exactly(width);
    const SampleRange range{samples_, samples_ + batch};
    tracers_[0]->trace({y, 0, width}, range, other, counts_);
    tracers_[1]->trace({y, 0, width}, range, exactly, counts_);
    const double whole = static_cast<double>(width) * settings_.height;
    for (std::uint32_t x = 0; x < width; ++x) {
      exactly_[std::size_t{y} * width + x] += exactly[x];
      const std::size_t part = 3 * (y / block * block_columns() + x / block);
      for (std::size_t c = 0; c < 3; ++c) {
        const double d =
            scale_.mean(other[x].sum[c], batch) - scale_.mean(exactly[x].sum[c], batch);
        differences[part + c] += d / (block * block);
        differences[differences.size() - 3 + c] += d / whole;
      }
    }
  }

  /// Returns the standard error of each part of f64's picture with reference_samples per pixel.
  [[nodiscard]] std::vector<double> monte_carlo_errors() const {
    std::vector<double> errors(parts_.size());
    const double whole = static_cast<double>(exactly_.size());
    for (std::size_t i = 0; i < exactly_.size(); ++i) {
      const std::size_t y = i / settings_.width;
      const std::size_t x = i % settings_.width;
      const std::size_t part = 3 * (y / block * block_columns() + x / block);
      for (std::size_t c = 0; c < 3; ++c) {
        const double mean = scale_.mean(exactly_[i].sum[c], samples_);
        const double variance = std::max(
            scale_.mean_square(exactly_[i].sum_of_squares[c], samples_) - mean * mean, 0.0);
        errors[part + c] += variance / reference_samples / (1.0 * block * block * block * block);
        errors[errors.size() - 3 + c] += variance / reference_samples / (whole * whole);
      }
    }
    for (double& error : errors) error = std::sqrt(error);
    return errors;
  }

  RenderSettings settings_;
  RadianceScale scale_;
  std::array<std::unique_ptr<PathTracer>, 2> tracers_;  ///< the other precision, f64
  std::vector<PixelSums> exactly_;
  std::vector<Part> parts_;  ///< three channels of each block, then of the picture
  TraceCounts counts_;
  std::uint32_t samples_ = 0;
  double floor_ = 0;
};

}  // namespace parray::test
