#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/measure/tradeoff/error_intervals.h"
#include "cli/measure/tradeoff/variant.h"

/// What measurements of renders say together. Pure functions; errors are RMSE in linear radiance,
/// over pixels and channels.
namespace parray::tradeoff {

/// One number for each of interval_levels.
using ByLevel = std::array<double, interval_levels.size()>;

/// One render against the reference.
struct Run {
  std::string options;  ///< canonical
  std::uint64_t seed = 0;
  double seconds = 0;       ///< of tracing, and of denoising, by the clock on the wall
  double cpu_seconds = 0;   ///< of all threads together
  double samples = 0;       ///< a pixel, mean
  double rays = 0;          ///< a sample, mean
  double mse = 0;           ///< against the true picture; may fall below 0 by chance
  double mse_scatter = 0;   ///< standard error of `mse`, from the reference's own error
  double mse_8bit = 0;      ///< of the PNG
  double quantisation = 0;  ///< mean square of what 8 bits change
  double bias = 0;          ///< mean error
  double claimed = 0;       ///< RMSE that the picture states, and its interval
  double low = 0;
  double high = 0;
  double truncation = 0;  ///< bound of the light lost to max_depth, mean radiance
  double passes = 1;
  double denoise_seconds = 0;  ///< the part of `seconds` that is features and filter
  ByLevel coverage{};          ///< share of pixels' intervals that hold; 0 where denoised
  ByLevel claims{};            ///< whether the interval of its RMSE holds: 0 or 1
};

/// Whether an interval of the RMSE around `claimed` holds, wider by what the reference does not
/// know.
bool claim_holds(const Run& run, double low, double high, std::size_t level);

/// Mean square of a systematic difference, from paired renders.
struct PairedBias {
  double square = 0;   ///< may fall below 0 by chance
  double scatter = 0;  ///< standard error of `square`
  double mean = 0;     ///< mean difference
  /// Its root mean square; 0 where it cannot be told from 0.
  [[nodiscard]] double rms() const;
};

/// What a picture's error is made of, as RMSE.
struct Budget {
  double monte_carlo = 0;                       ///< as the pictures state it, by their replicates
  double depth = 0;                             ///< against paths without end, by paired renders
  double precision = 0;                         ///< against f64, by paired renders
  double quantisation = 0;                      ///< of 8 bits; for PNG only
  [[nodiscard]] double predicted() const;       ///< of EXR: without quantisation
  [[nodiscard]] double predicted_8bit() const;  ///< of PNG
};

struct Quartiles {
  double q1 = 0;
  double median = 0;
  double q3 = 0;
};
/// By linear interpolation between ranks. Precondition: not empty.
Quartiles quartiles_of(std::vector<double> values);

/// Settings with what their runs say.
struct Row {
  Knob knob = Knob::spp;
  RenderSettings settings;
  std::string options;
  std::size_t runs = 0;
  Quartiles seconds;       ///< Timing::seconds_of()
  double cpu_seconds = 0;  ///< median
  double samples = 0;
  double rays = 0;
  double mse = 0;             ///< mean
  double mse_deviation = 0;   ///< standard deviation of one run's
  double rmse = 0;            ///< square root of mse, 0 if that is below 0
  double rmse_deviation = 0;  ///< of one run's
  double rmse_8bit = 0;
  double claimed = 0;  ///< root mean square
  ByLevel claims{};    ///< share of runs whose interval holds rmse
  double bias = 0;
  double truncation = 0;
  ByLevel coverage{};  ///< of pixels' intervals, which denoised pictures have not
  double passes = 1;
  double denoise_seconds = 0;
  Budget budget;
  bool on_front = false;
  std::string dominated_by;  ///< canonical; empty on the front

  double mse_scatter = 0;  ///< Run::mse_scatter, mean: the same for all runs

  [[nodiscard]] double ratio() const { return rmse > 0 ? budget.predicted() / rmse : 0; }
  [[nodiscard]] double ratio_8bit() const {
    return rmse_8bit > 0 ? budget.predicted_8bit() / rmse_8bit : 0;
  }
  /// 1 / (MSE x seconds).
  [[nodiscard]] double efficiency() const {
    return mse > 0 && seconds.median > 0 ? 1 / (mse * seconds.median) : 0;
  }
};

/// How the time of a render is told.
struct Timing {
  bool busy = false;  ///< others use the processors, too: the clock on the wall says little
  int threads = 1;
  /// Of a render that has the processors for itself.
  [[nodiscard]] double seconds_of(const Run& run) const {
    return busy ? run.cpu_seconds / threads : run.seconds;
  }
};
/// Busy: the threads had less than 85 % of the time that they asked for.
Timing timing_of(const std::vector<Run>& runs, int threads);

/// Precondition: `runs` are of these settings, and not empty.
Row row_of(const Variant& variant, const std::vector<const Run*>& runs, const Timing& timing);

/// What a setting costs and what it gives.
struct CostAndError {
  double seconds = 0;
  double rmse = 0;
};
/// For each the fastest of those that are as fast and, but for a thousandth, as accurate; itself
/// where it is on the front: nothing else is.
std::vector<std::size_t> dominators_of(const std::vector<CostAndError>& points);

/// Marks the rows on the front of their time and error; the others learn what dominates them.
void mark_front(std::vector<Row>& rows);

/// ln y = intercept + slope ln x, by least squares.
struct PowerLaw {
  double intercept = 0;
  double slope = 0;
  double slope_error = 0;  ///< standard error; 0 with two points
  [[nodiscard]] double at(double x) const;
};
/// None with fewer than two points, or values that have no logarithm.
std::optional<PowerLaw> fit_power_law(const std::vector<std::pair<double, double>>& points);

/// y(x) along straight lines between points in log-log, beyond them as the last ones go.
class LogCurve {
 public:
  /// Points with positive values count; of points with one x the last. A single point is a line of
  /// slope `slope`; 0: that is not known.
  explicit LogCurve(const std::vector<std::pair<double, double>>& points, double slope = 0);
  [[nodiscard]] bool known() const { return points_.size() >= 2; }
  /// Precondition: known(), x > 0.
  [[nodiscard]] double at(double x) const;

 private:
  std::vector<std::pair<double, double>> points_;  ///< logarithms, x ascending
};

}  // namespace parray::tradeoff
