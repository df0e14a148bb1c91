#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/measure/tradeoff/variant.h"
#include "common/adaptive/error_estimate.h"

/// Statistics of the renders that `parray tradeoff` measures. Pure functions. Errors are RMSE in
/// linear radiance, over pixels and channels.
namespace parray::tradeoff {

/// Confidence levels, and the half-width of each in standard deviations of a normal distribution.
inline constexpr std::array<double, 5> interval_levels = {0.5, 0.8, 0.9, 0.95, 0.99};
inline constexpr std::array<double, 5> normal_half_widths = {0.674490, 1.281552, 1.644854, 1.959964,
                                                             2.575829};
inline constexpr std::size_t stated_level = 3;  ///< the level of ErrorEstimate, 95 %

/// Confidence intervals of other levels than the 95 % that pictures state. Stated intervals hold at
/// least 95 % of the time; narrower ones should hold exactly as often as their level. They come
/// from the picture alone, for any sampler. Wider intervals are the stated ones, widened as for a
/// normal distribution.
class ErrorIntervals {
 public:
  /// `error` must be estimate_error(state), and error.known() must be true.
  ErrorIntervals(const FramebufferView& state, const ErrorEstimate& error);

  /// Returns the factor for the stated half-widths of pixels at a level, by its index. Below 95 %
  /// it is a quantile, over the values of all pixels, of |A - B| / 2 divided by the stated
  /// half-width. A and B are the replicates of a value. (A - B) / 2 has the same distribution as
  /// the error (A + B) / 2 - mu, apart from the sign of one half (noise_model.h). Values whose
  /// replicates agree to the last bit do not count: they have no noise, or have not seen it yet.
  [[nodiscard]] double scale(std::size_t level) const { return scales_[level]; }

  struct Interval {
    double low = 0;
    double high = 0;
  };
  /// Returns the interval of the picture's RMSE. Below 95 % its width follows from the variance of
  /// the square error: the geometric mean of an upper and a lower estimate. With u and w the errors
  /// of a pixel's replicates, that variance is the sum over pixels of the mean of (uw)^2
  /// (error_estimate.cpp). The estimate from each pixel's own samples, and the correlation of its
  /// channels, is too high: a rare bright sample raises both factors. The estimate from products of
  /// differences of neighbouring pixels, which share no noise, is too low: noise varies from pixel
  /// to pixel. Light that no sample has shown is left to the wide intervals.
  [[nodiscard]] Interval rmse(std::size_t level) const { return rmse_[level]; }

 private:
  std::array<double, 5> scales_{};
  std::array<Interval, 5> rmse_{};
};

/// One number for each of interval_levels.
using ByLevel = std::array<double, interval_levels.size()>;

/// One render, compared with the reference (reference.h), which approximates the true picture.
struct Run {
  std::string options;  ///< options_of() of the settings
  std::uint64_t seed = 0;
  double seconds = 0;       ///< wall-clock time of tracing and denoising
  double cpu_seconds = 0;   ///< processor time of all threads
  double samples = 0;       ///< mean per pixel
  double rays = 0;          ///< mean per sample
  double mse = 0;           ///< estimate of the mean square error; may be below 0 by chance
  double mse_scatter = 0;   ///< standard error of `mse`, from the reference's own error
  double mse_8bit = 0;      ///< `mse` of the picture rounded to 8 bits
  double quantisation = 0;  ///< mean square of the change by rounding to 8 bits
  double bias = 0;          ///< mean of picture minus reference
  double claimed = 0;       ///< RMSE that the picture states
  double low = 0;           ///< the 95 % interval that the picture states for its RMSE
  double high = 0;
  /// Upper bound of the mean radiance that is lost because paths end at max_depth.
  double truncation = 0;
  double passes = 1;           ///< number of passes
  double denoise_seconds = 0;  ///< the part of `seconds` for denoising: features and filter
  /// Share of the pixels' intervals that contain the true value; 1 if no pixel has noise. 0 for
  /// denoised pictures and for pictures that state no error.
  ByLevel coverage{};
  /// 1: the picture's interval of its RMSE contains the true RMSE. 0: it does not, or the picture
  /// has no such interval.
  ByLevel claims{};
};

/// Returns whether the interval from `low` to `high` around Run::claimed contains the true RMSE.
/// First widens it by the uncertainty of the reference. `level`: confidence level of the interval,
/// as its index in interval_levels.
bool claim_holds(const Run& run, double low, double high, std::size_t level);

/// Mean square of a systematic difference, from paired renders.
struct PairedBias {
  double square = 0;   ///< may fall below 0 by chance
  double scatter = 0;  ///< standard error of `square`
  double mean = 0;     ///< mean difference
  /// Returns the root of `square`, or 0 if `square` is at most two standard errors.
  [[nodiscard]] double rms() const;
};

/// The parts of a picture's error, as RMSE.
struct Budget {
  double monte_carlo = 0;                  ///< the stated error, from replicates
  double depth = 0;                        ///< relative to unlimited paths, from paired renders
  double precision = 0;                    ///< relative to f64, from paired renders
  double quantisation = 0;                 ///< of 8 bits, for PNG only
  [[nodiscard]] double predicted() const;  ///< of an EXR file: without quantisation
  [[nodiscard]] double predicted_8bit() const;  ///< of a PNG file
};

struct Quartiles {
  double q1 = 0;
  double median = 0;
  double q3 = 0;
};
/// Returns quartiles, with linear interpolation between ranks. `values` must not be empty.
Quartiles quartiles_of(std::vector<double> values);

/// Statistics of all runs of the same settings.
struct Row {
  VariedSetting varied = VariedSetting::spp;
  Boxed<RenderSettings> settings;
  std::string options;
  std::size_t runs = 0;
  Quartiles seconds;           ///< Timing::seconds_of()
  double cpu_seconds = 0;      ///< median
  double samples = 0;          ///< per pixel, mean
  double rays = 0;             ///< per sample, mean
  double mse = 0;              ///< mean
  double mse_deviation = 0;    ///< standard deviation of the `mse` of one run
  double rmse = 0;             ///< square root of mse; 0: not known, because mse is not above 0
  double rmse_deviation = 0;   ///< standard deviation of the RMSE of one run
  double rmse_8bit = 0;        ///< square root of the mean of Run::mse_8bit; 0 if that is below 0
  double claimed = 0;          ///< root mean square of Run::claimed
  ByLevel claims{};            ///< share of runs whose interval contains the true RMSE
  double bias = 0;             ///< mean
  double truncation = 0;       ///< mean
  ByLevel coverage{};          ///< mean of Run::coverage; unused for denoised pictures
  double passes = 1;           ///< mean
  double denoise_seconds = 0;  ///< the part of the median of `seconds` for denoising
  Budget budget;
  bool on_front = false;
  /// The options_of() of faster settings whose error is no larger. Empty on the Pareto front, and
  /// for an error that is not known.
  std::string dominated_by;

  /// Mean of Run::mse_scatter. More runs do not reduce it, because all use one reference.
  double mse_scatter = 0;

  /// Return the predicted error divided by the measured one, or 0 if that is 0.
  [[nodiscard]] double ratio() const { return rmse > 0 ? budget.predicted() / rmse : 0; }
  [[nodiscard]] double ratio_8bit() const {
    return rmse_8bit > 0 ? budget.predicted_8bit() / rmse_8bit : 0;
  }
  /// Returns 1 / (MSE x seconds), or 0 if one of the two is not positive.
  [[nodiscard]] double efficiency() const {
    return mse > 0 && seconds.median > 0 ? 1 / (mse * seconds.median) : 0;
  }
};

/// How the time of a render is measured.
struct Timing {
  bool busy = false;  ///< threads got too little processor time: wall-clock time is unreliable
  int threads = 1;    ///< of each render
  /// Returns the time of a render that has the processors for itself.
  [[nodiscard]] double seconds_of(const Run& run) const {
    return busy ? run.cpu_seconds / threads : run.seconds;
  }
};
/// Sets `busy` if the threads got less than 85 % of the processor time that they could use.
Timing timing_of(const std::vector<Run>& runs, int threads);

/// Returns the statistics of `runs`, which must have the settings of `variant` and must not be
/// empty. Leaves Budget::depth, Budget::precision and the Pareto front to rows_of().
Row row_of(const Variant& variant, const std::vector<const Run*>& runs, const Timing& timing);

/// Time and error of settings.
struct CostAndError {
  double seconds = 0;
  double rmse = 0;
};
/// Returns, for each point, the index of the fastest point that dominates it: a point that is at
/// least as fast, at least as accurate within 0.1 %, and better in one of the two. Points that no
/// other dominates are on the Pareto front and get their own index.
std::vector<std::size_t> dominators_of(const std::vector<CostAndError>& points);

/// Marks the rows on the Pareto front of time and error, and sets `dominated_by` of the others.
/// Rows whose error is not known are not on the front and dominate no row.
void mark_front(std::vector<Row>& rows);

/// ln y = intercept + slope ln x, by least squares.
struct PowerLaw {
  double intercept = 0;
  double slope = 0;
  double slope_error = 0;  ///< standard error; 0 with two points
  [[nodiscard]] double at(double x) const;
};
/// Returns nothing if a value of any point is not positive, or for fewer than two different x.
std::optional<PowerLaw> fit_power_law(const std::vector<std::pair<double, double>>& points);

/// y(x) by linear interpolation in log-log, and extrapolation by the outermost segments.
class LogCurve {
 public:
  /// Uses points with positive values; of points with equal x the last. A single point gives a line
  /// of slope `slope`; 0: the curve is unknown.
  explicit LogCurve(const std::vector<std::pair<double, double>>& points, double slope = 0);
  [[nodiscard]] bool known() const { return points_.size() >= 2; }
  /// Precondition: known(), x > 0.
  [[nodiscard]] double at(double x) const;

 private:
  std::vector<std::pair<double, double>> points_;  ///< logarithms, x ascending
};

}  // namespace parray::tradeoff
