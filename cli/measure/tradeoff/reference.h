#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/measure/tradeoff/analysis.h"
#include "cli/output/denoise/denoise.h"

namespace parray::tradeoff {

/// What a picture would be with endless samples, nearly: from independent samples, as two halves
/// that have no seed in common. With the halves' errors u and w, a picture's error e fulfils
/// E[(e - u)(e - w)] = E[e^2]: the reference's own error takes itself off.
class Reference {
 public:
  Reference(std::uint32_t width, std::uint32_t height);

  /// Settings of every render that goes into it: f64, independent, deep.
  static RenderSettings settings_of(const RenderSettings& base);

  /// Adds a render to a half: the next one in turn. Settings other than the seed and the samples
  /// are always the same.
  void add(const DirectRender& chunk);
  [[nodiscard]] std::uint64_t chunks() const { return chunks_; }  ///< also the next one's number

  /// Of each pixel, both halves together.
  [[nodiscard]] double samples() const { return samples_[0] + samples_[1]; }
  /// Both halves have samples, as many.
  [[nodiscard]] bool balanced() const { return samples_[0] > 0 && samples_[0] == samples_[1]; }
  /// Of the mean of both halves, from how they differ. Precondition: balanced().
  [[nodiscard]] double rmse() const;

  /// The picture's errors, and how often what it states of them holds; settings, time and work of
  /// the render are left open. Pixels without noise are not asked. Precondition: balanced(), the
  /// same size.
  [[nodiscard]] Run compare(const DirectRender& picture) const;
  /// The same of a denoised picture, which says nothing of its pixels.
  [[nodiscard]] Run compare(const Denoised& picture) const;

  /// An EXR file: the mean as RGB, both halves and the variance of a sample as further channels.
  void save(const std::filesystem::path& path) const;
  /// Throws InputError when it is not such a file, or of another size.
  void load(const std::filesystem::path& path);

 private:
  [[nodiscard]] double mean(std::size_t i) const { return (half_[0][i] + half_[1][i]) / 2; }
  /// Of the mean.
  [[nodiscard]] double variance(std::size_t i) const;
  [[nodiscard]] Run errors_of(const std::vector<float>& picture) const;
  [[nodiscard]] ByLevel coverage_of(const std::vector<float>& picture,
                                    const ErrorEstimate& estimate,
                                    const ErrorIntervals& intervals) const;

  std::uint32_t width_;
  std::uint32_t height_;
  std::array<std::vector<double>, 2> half_;  ///< mean of each value
  std::vector<double> square_;               ///< mean of squares, both halves
  std::array<double, 2> samples_{};          ///< a pixel
  std::uint64_t chunks_ = 0;
};

/// What a value of linear light becomes in an 8-bit sRGB picture, as linear light.
double through_8bit(double value);

}  // namespace parray::tradeoff
