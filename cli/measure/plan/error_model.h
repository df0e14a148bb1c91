#pragma once

#include <span>
#include <utility>
#include <vector>

#include "common/adaptive/passes.h"

/// How the error of a picture falls as samples are added: measured at a few numbers of samples,
/// foreseen at others. Samples are means per pixel; errors are RMSE in linear radiance.
namespace parray::plan {

/// What independent samples would do: E = s / sqrt(n) where every pixel has as many; less where
/// they go to the pixels that are noisy.
class ModelError {
 public:
  /// Equal counts. `deviation` > 0: of a sample, root mean square over pixels and channels.
  static ModelError uniform(double deviation);
  /// As adaptive passes go on from `state`, in which all pixels have as many samples, at least 2;
  /// `rmse` > 0: its error.
  static ModelError adaptive(const FramebufferView& state, double rmse);

  [[nodiscard]] double at(double samples) const;
  /// The inverse of at().
  [[nodiscard]] double samples_for(double rmse) const;

 private:
  /// Logarithms of samples and error, the former ascending; beyond both ends E falls as 1/sqrt(n).
  explicit ModelError(std::vector<std::pair<double, double>> points) : points_(std::move(points)) {}
  std::vector<std::pair<double, double>> points_;
};

struct MeasuredError {
  double samples = 0;
  double rmse = 0;
  double relative = 0;  ///< standard error of rmse / rmse
};

/// Normal distribution of an exponent.
struct ExponentPrior {
  double mean = 0;
  double deviation = 0;  ///< 0: it is known
};

/// Sobol points are spread most evenly where their number is a power of two; any other number does
/// as well as fewer points of a smooth law: returns how many, for `samples` > 0 of each pixel, as
/// many in each of its two replicates. Measured over six scenes, 4 to 512 samples:
/// tests/experiments/RESULTS.md.
double even_points(double samples);

/// What the samples of an ErrorModel are.
enum class Spread {
  smooth,  ///< independent samples, or numbers that differ from pixel to pixel
  points   ///< as many Sobol points for every pixel: the exponent is that of even_points()
};

/// E(n) = model(n) * g(n). g is what a sampler does better than independent samples: between
/// measurements interpolated, in logarithms, and beyond them in proportion to n^-d. The exponent d
/// comes of weighted least squares with a prior, which is the posterior's mean for normal errors
/// (Gelman et al., Bayesian Data Analysis, 3rd ed., section 14.8); a measurement counts for less
/// the fewer samples it has, because the law need not hold over many octaves. Where d is known, g
/// is the weighted mean of all measurements times n^-d.
class ErrorModel {
 public:
  /// At least one measurement, of positive errors, by ascending samples.
  ErrorModel(ModelError model, std::span<const MeasuredError> measured, ExponentPrior exponent,
             Spread spread = Spread::smooth);

  [[nodiscard]] double at(double samples) const;
  /// The inverse of at().
  [[nodiscard]] double samples_for(double rmse) const;
  /// Standard error of at() / at().
  [[nodiscard]] double relative_at(double samples) const;
  [[nodiscard]] double exponent() const { return exponent_; }
  [[nodiscard]] const ModelError& model() const { return model_; }

 private:
  struct Gain {
    double samples = 0;  ///< logarithm
    double points = 0;   ///< logarithm of what the exponent belongs to, see Spread
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

/// What a picture will have when its passes have ended.
struct Forecast {
  double samples = 0;  ///< a pixel
  double rmse = 0;
  int passes = 0;
  int decisions = 0;  ///< of these, how many begin with a decision on where samples go
};

/// The upper end of the interval that a picture states for its error, from the error:
/// sqrt(factor * rmse^2 + unseen / n); see ErrorEstimate. A target is met when that meets it.
struct UpperBound {
  double factor = 1;
  double unseen = 0;
  [[nodiscard]] double of(double rmse, double samples) const;
};

/// How the error of a picture goes that is to meet a target.
struct TargetLaws {
  const ErrorModel& even;    ///< while every pixel has the same number of samples
  const ErrorModel& placed;  ///< once samples go where the noise is
  UpperBound stated_even;
  UpperBound stated_placed;
  Sampler sampler = Sampler::independent;
  /// Whether samples are ever placed: from pilot_samples on, by a pass of half of them at least.
  bool placing_pays = true;
};

/// Where adaptive passes end that go on until the stated error meets `target`: the sizes of passes
/// as next_pass_size() has them. They end at `most_samples` a pixel, too.
Forecast forecast_target(const TargetLaws& laws, double target, double most_samples);

/// Seconds that passes take.
struct PassCosts {
  double pilot_sample = 0;  ///< of one sample of each pixel in the first pass
  double later_sample = 0;  ///< in those after it
  double pass = 0;          ///< of a pass, whatever its size
};

/// Where adaptive passes end that have a time limit, `seconds` of which are left for them. At
/// least 2 samples a pixel: a picture of fewer does not know its error. Its rmse is 0: it does not
/// matter to them.
Forecast forecast_time(const PassCosts& costs, double seconds, double most_samples);

}  // namespace parray::plan
