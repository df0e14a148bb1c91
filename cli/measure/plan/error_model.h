#pragma once

#include <span>
#include <utility>
#include <vector>

#include "common/adaptive/passes.h"

/// Models how the error of a picture falls with samples, from measurements at a few numbers of
/// samples. Samples are means per pixel; errors are RMSE in linear radiance.
namespace parray::plan {

/// A model of the error E of a picture with independent samples, n per pixel on average. If every
/// pixel has n samples, E = s / sqrt(n), where s is the standard deviation of a sample. If noisy
/// pixels get more samples than others, E is less.
class ModelError {
 public:
  /// Returns the model for the same number of samples in every pixel. `deviation` > 0: standard
  /// deviation of a sample, root mean square over pixels and channels.
  static ModelError uniform(double deviation);
  /// Returns the model for adaptive passes that continue from the picture `state`. In `state` all
  /// pixels must have the same number of samples, at least 2. `rmse` > 0: the error of `state`.
  static ModelError adaptive(const FramebufferView& state, double rmse);

  /// Returns the error with `samples` > 0 per pixel.
  [[nodiscard]] double at(double samples) const;
  /// Returns the samples with the error `rmse`: the inverse of at().
  [[nodiscard]] double samples_for(double rmse) const;

 private:
  /// Logarithms of samples (ascending) and error. Beyond both ends E falls as 1/sqrt(n).
  explicit ModelError(std::vector<std::pair<double, double>> points) : points_(std::move(points)) {}
  std::vector<std::pair<double, double>> points_;
};

struct MeasuredError {
  double samples = 0;
  double rmse = 0;
  double relative = 0;  ///< standard error of `rmse`, divided by `rmse`
};

/// Normal distribution of an exponent.
struct ExponentPrior {
  double mean = 0;
  double deviation = 0;  ///< 0: the exponent is known
};

/// Returns how many evenly spread points `samples` > 0 Sobol points per pixel are worth. Their
/// advantage over independent samples is a power of the result. The result equals `samples` for
/// powers of four, which are spread most evenly, and is less for other numbers. Each replicate has
/// half of the points. Measured over six scenes, 4 to 512 samples: tests/experiments/RESULTS.md.
double even_points(double samples);

/// Kind of the samples of an ErrorModel.
enum class Spread {
  smooth,  ///< independent samples, or different numbers of samples per pixel
  /// The same number of Sobol points in every pixel: the gain of ErrorModel is a power of
  /// even_points(n).
  points
};

/// E(n) = model(n) * g(n). The factor g is the advantage of a sampler over independent samples. It
/// is interpolated in logarithms between measurements and proportional to n^-d beyond them.
/// Weighted least squares with a prior give the exponent d, the posterior mean for normal errors
/// (Gelman et al., Bayesian Data Analysis, 3rd ed., section 14.8). Measurements of fewer samples
/// have smaller weights, because the law need not hold over many octaves. If d is known, g is the
/// weighted mean of all measurements times n^-d.
class ErrorModel {
 public:
  /// `measured`: at least one measurement, with positive errors and ascending samples.
  ErrorModel(ModelError model, std::span<const MeasuredError> measured, ExponentPrior exponent,
             Spread spread = Spread::smooth);

  [[nodiscard]] double at(double samples) const;
  /// Returns the samples per pixel with the error `rmse`.
  [[nodiscard]] double samples_for(double rmse) const;
  /// Returns the standard error of at(), divided by at().
  [[nodiscard]] double relative_at(double samples) const;
  [[nodiscard]] double exponent() const { return exponent_; }
  [[nodiscard]] const ModelError& model() const { return model_; }

 private:
  struct Gain {
    double samples = 0;  ///< logarithm
    double points = 0;   ///< logarithm of the number that the exponent belongs to, see Spread
    double gain = 0;     ///< logarithm
    double relative = 0;
    double weight = 0;
  };
  void fit_exponent(ExponentPrior prior);
  void average_gains();
  [[nodiscard]] double points_of(double samples) const;

  ModelError model_;
  Spread spread_;
  std::vector<Gain> gains_;
  double exponent_ = 0;
  double exponent_variance_ = 0;
};

/// A prediction of a picture after its last pass.
struct Forecast {
  double samples = 0;  ///< mean per pixel
  double rmse = 0;
  int passes = 0;
  int decisions = 0;  ///< number of passes that begin with a decision on the placement of samples
};

/// The upper end of the confidence interval of a picture's error, as a function of the error and of
/// the number n of samples per pixel: sqrt(factor * rmse^2 + unseen / n). `unseen` stands for light
/// that no sample has shown; see ErrorEstimate. A picture meets its target when this upper end is
/// at most the target.
struct UpperBound {
  double factor = 1;
  double unseen = 0;
  [[nodiscard]] double of(double rmse, double samples) const;
};

/// Error laws of a picture with a target.
struct TargetLaws {
  const ErrorModel& even;    ///< every pixel has the same number of samples
  const ErrorModel& placed;  ///< noisy pixels have more samples
  UpperBound stated_even;    ///< upper end for the errors of `even`
  UpperBound stated_placed;  ///< upper end for the errors of `placed`
  Sampler sampler = Sampler::independent;
  /// Whether passes place samples by noise: from pilot_samples (passes.h) per pixel on, in a pass
  /// that adds at least half as many samples as there are.
  bool placing_pays = true;
};

/// Predicts the picture at the end of adaptive passes. They continue until UpperBound::of() meets
/// `target`, or the picture has `most_samples` per pixel. next_pass_size() gives the sizes of the
/// passes.
Forecast forecast_target(const TargetLaws& laws, double target, double most_samples);

/// Seconds that passes take.
struct PassCosts {
  double pilot_sample = 0;  ///< one sample of every pixel in the first pass
  double later_sample = 0;  ///< one sample of every pixel in later passes
  double pass = 0;          ///< each pass, for any number of samples
};

/// Predicts the picture at the end of adaptive passes with `seconds` for them all, and at most
/// `most_samples` per pixel. The result has at least 2 samples per pixel, because the error of a
/// picture with fewer is unknown. Its `rmse` is not predicted: 0.
Forecast forecast_time(const PassCosts& costs, double seconds, double most_samples);

}  // namespace parray::plan
