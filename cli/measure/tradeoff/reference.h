#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/measure/tradeoff/analysis.h"
#include "cli/output/denoise/denoise.h"

namespace parray::tradeoff {

/// Approximates the true picture, with infinitely many samples. It has two halves, each the mean of
/// independent samples; no seed is in both. Let u and w be the errors of the halves. A picture's
/// error e then satisfies E[(e - u)(e - w)] = E[e^2]. So the error of the reference cancels.
class Reference {
 public:
  Reference(std::uint32_t width, std::uint32_t height);

  /// Returns the settings of the reference's renders: f64, independent samples, great depth.
  static RenderSettings settings_of(const RenderSettings& base);

  /// Adds a render to one half, and the next one to the other. Only the seed and the number of
  /// samples may differ between renders.
  void add(const DirectRender& chunk);
  /// Returns the number of added renders. It is also the number of the next one, for
  /// reference_seed().
  [[nodiscard]] std::uint64_t chunks() const { return chunks_; }

  /// Returns the samples per pixel of both halves together.
  [[nodiscard]] double samples() const { return samples_[0] + samples_[1]; }
  /// Returns whether both halves have the same number of samples, above 0.
  [[nodiscard]] bool balanced() const { return samples_[0] > 0 && samples_[0] == samples_[1]; }
  /// Returns the RMSE of the mean of both halves, from their difference. Precondition: balanced().
  [[nodiscard]] double rmse() const;

  /// Compares a picture with the reference. Returns its errors, and how often its stated intervals
  /// contain the true value; pixels without noise do not count for Run::coverage. Does not set the
  /// settings, times and work of the run. Precondition: balanced(), and the same size.
  [[nodiscard]] Run compare(const DirectRender& picture) const;
  /// Does the same for a denoised picture, which states no intervals of its pixels.
  [[nodiscard]] Run compare(const Denoised& picture) const;

  /// Writes an EXR file: the mean as RGB, and both halves and the variance of a sample as further
  /// channels. Throws RunError. Precondition: balanced().
  void save(const std::filesystem::path& path) const;
  /// Reads a file of save(). Throws InputError if the file is not from save() or has another size.
  void load(const std::filesystem::path& path);

 private:
  [[nodiscard]] double mean(std::size_t i) const { return (half_[0][i] + half_[1][i]) / 2; }
  /// Returns the variance of mean(i).
  [[nodiscard]] double variance(std::size_t i) const;
  [[nodiscard]] Run errors_of(const std::vector<float>& picture) const;
  [[nodiscard]] ByLevel coverage_of(const std::vector<float>& picture,
                                    const ErrorEstimate& estimate,
                                    const ErrorIntervals& intervals) const;

  std::uint32_t width_;
  std::uint32_t height_;
  std::array<std::vector<double>, 2> half_;  ///< mean of each value
  std::vector<double> square_;               ///< mean square of each value, of both halves
  std::array<double, 2> samples_{};          ///< a pixel
  std::uint64_t chunks_ = 0;
};

/// Returns the linear value of the nearest 8-bit sRGB code, clamped to [0, 1].
double through_8bit(double value);

}  // namespace parray::tradeoff
