#include "cli/measure/tradeoff/answer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cli/output/text.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

/// The effect of another depth, precision or accelerator on uniform samples, relative to the
/// scene's own settings.
struct Change {
  std::uint32_t depth = 0;
  Precision precision = Precision::automatic;
  AcceleratorKind accelerator = AcceleratorKind::automatic;
  double time = 1;      ///< factor
  double variance = 1;  ///< factor
  double bias_square = 0;
};

double square(double value) { return value * value; }

double bias_square_of(const RenderSettings& settings, const PairedBiases& biases) {
  const auto depth = biases.depth.find(settings.max_depth);
  const auto precision = biases.precision.find(settings.precision);
  return (depth == biases.depth.end() ? 0 : square(depth->second.rms())) +
         (precision == biases.precision.end() ? 0 : square(precision->second.rms()));
}

Change no_change(const RenderSettings& base) {
  Change own;
  own.depth = base.max_depth;
  own.precision = base.precision;
  own.accelerator = base.accelerator;
  return own;
}

/// Returns the scene's own settings first, then the measured changes.
std::vector<Change> changes_of(const std::vector<Row>& rows, const RenderSettings& base,
                               const PairedBiases& biases) {
  std::vector<Change> changes = {no_change(base)};
  changes[0].bias_square = bias_square_of(base, biases);
  for (const Row& row : rows) {
    RenderSettings without = row.settings;
    without.max_depth = base.max_depth;
    without.precision = base.precision;
    without.accelerator = base.accelerator;
    const Row* plain = row_with(rows, without);
    const bool changed = row.varied == VariedSetting::depth ||
                         row.varied == VariedSetting::precision ||
                         row.varied == VariedSetting::accelerator;
    if (!changed || plain == nullptr || plain == &row || !(plain->budget.monte_carlo > 0)) continue;
    changes.push_back({row.settings->max_depth, row.settings->precision, row.settings->accelerator,
                       row.seconds.median / plain->seconds.median,
                       square(row.budget.monte_carlo / plain->budget.monte_carlo),
                       bias_square_of(row.settings, biases)});
  }
  return changes;
}

/// The results of one way to use samples, denoised or not, with the scene's own depth and
/// precision. The amount is the samples per pixel, or the target error.
struct Family {
  RenderSettings settings;
  LogCurve amount;   ///< for a Monte Carlo RMSE
  LogCurve seconds;  ///< for an amount
  bool targeted = false;
};

/// A way to use samples. The slopes are those of Family::amount and Family::seconds with a single
/// row: four times the samples halve the noise. For a denoised picture a single row does not
/// determine the slopes (0). No way has a target and denoising, because the sweep (variant.cpp)
/// measures no denoised pictures with targets.
struct Way {
  bool targeted, denoised;
  double amount_slope, seconds_slope;
};
constexpr std::array<Way, 3> ways{
    {{false, false, -2, 1}, {false, true, 0, 0}, {true, false, 1, -2}}};

std::vector<Family> measured_families(const std::vector<Row>& rows, const RenderSettings& base) {
  std::vector<Family> families;
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    for (const Way& way : ways) {
      RenderSettings settings = with_denoise(base, way.denoised);
      settings.sampler = sampler;
      settings.adaptive = false;
      settings.target_error = 0;
      if (way.targeted) settings = with_target(settings, sampler, 1);
      std::vector<std::pair<double, double>> amount;
      std::vector<std::pair<double, double>> seconds;
      for (const Row& row : rows) {
        if (!same_but_samples(row.settings, settings)) continue;
        const double spent =
            way.targeted ? row.settings->target_error : row.settings->samples_per_pixel;
        amount.emplace_back(row.budget.monte_carlo, spent);
        seconds.emplace_back(spent, row.seconds.median);
      }
      families.push_back({settings, LogCurve(amount, way.amount_slope),
                          LogCurve(seconds, way.seconds_slope), way.targeted});
    }
  }
  return families;
}

/// Returns an even number of samples, because both replicates of a pixel get the same number.
std::uint32_t samples_from(double amount) {
  const double most = limits::max_samples_per_pixel;
  return static_cast<std::uint32_t>(2 * std::ceil(std::clamp(amount, 2.0, most) / 2));
}

/// Returns a target with three digits. Rounds down, because the error must not exceed it.
double target_from(double amount) {
  const double unit = std::pow(10, std::floor(std::log10(amount)) - 2);
  return std::stod(formatted("%.3g", std::floor(amount / unit + 1e-9) * unit));
}

std::optional<Candidate> candidate_of(const Family& family, const Change& change, double error) {
  const double left = square(error) - change.bias_square;
  if (!family.amount.known() || !family.seconds.known() || !(left > 0)) return std::nullopt;
  Candidate candidate{family.settings, 0};
  RenderSettings& settings = candidate.settings;
  settings.max_depth = change.depth;
  settings.precision = change.precision;
  settings.accelerator = change.accelerator;
  double spent = 0;
  if (family.targeted) {
    settings.target_error = target_from(std::sqrt(left));
    spent = settings.target_error;
  } else {
    spent = family.amount.at(std::sqrt(left / change.variance));
    if (!(spent <= limits::max_samples_per_pixel)) return std::nullopt;
    settings.samples_per_pixel = samples_from(spent);
    spent = settings.samples_per_pixel;
  }
  const double variance = family.targeted ? change.variance : 1;
  candidate.seconds = family.seconds.at(spent) * change.time * variance;
  return candidate;
}

std::string times_text(double times) {
  if (times < 1.05) return "take about as long";
  return "take " + formatted(times < 10 ? "%.1f" : "%.0f", times) + " x as long";
}

}  // namespace

const Row* row_with(const std::vector<Row>& rows, const RenderSettings& settings) {
  const auto found = std::ranges::find(rows, options_of(settings), &Row::options);
  return found == rows.end() ? nullptr : &*found;
}

bool same_but_samples(const RenderSettings& a, const RenderSettings& b) {
  return a.sampler == b.sampler && a.max_depth == b.max_depth && a.precision == b.precision &&
         a.accelerator == b.accelerator && a.isa == b.isa &&
         (a.target_error > 0) == (b.target_error > 0) && a.adaptive == b.adaptive &&
         a.replicates == b.replicates;
}

std::vector<Candidate> candidates_for(double error, const std::vector<Row>& rows,
                                      const RenderSettings& base, const PairedBiases& biases) {
  const std::vector<Change> changes = changes_of(rows, base, biases);
  std::vector<Candidate> candidates;
  for (const Family& family : measured_families(rows, base)) {
    // Nothing, if the bias of the scene's own depth or precision alone exceeds the error.
    auto best = candidate_of(family, changes[0], error);
    double limit = best ? 0.95 * best->seconds : std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < changes.size() && !family.settings.replicates; ++i) {
      if (changes[i].bias_square > square(error) / 10) continue;
      const auto other = candidate_of(family, changes[i], error);
      if (other && other->seconds < limit) {
        best = other;
        limit = other->seconds;
      }
    }
    if (best) candidates.push_back(*best);
  }
  std::ranges::sort(candidates, {}, &Candidate::seconds);
  return candidates;
}

std::optional<Candidate> own_for(double error, const std::vector<Row>& rows,
                                 const RenderSettings& base) {
  for (const Family& family : measured_families(rows, base)) {
    if (same_but_samples(family.settings, with_denoise(base, false)) && !family.targeted) {
      return candidate_of(family, no_change(base), error);
    }
  }
  return std::nullopt;
}

std::optional<Candidate> corrected(const Row& row, double error) {
  const double ratio = row.rmse / error;
  const bool targeted = row.settings->target_error > 0;
  if (!(ratio > 0) || (ratio <= 1.005 && (targeted || ratio > 0.97))) return std::nullopt;
  RenderSettings settings = row.settings;
  if (targeted) {
    settings.target_error = target_from(settings.target_error / (ratio * 1.002));
  } else {
    settings.samples_per_pixel = samples_from(settings.samples_per_pixel * square(ratio));
  }
  if (options_of(settings) == row.options) return std::nullopt;
  return Candidate{settings, row.seconds.median * square(ratio)};
}

const Row* fastest_within(double error, const std::vector<Row>& rows) {
  const Row* fastest = nullptr;
  for (const Row& row : rows) {
    if (row.rmse > 0 && row.rmse <= error * 1.005 &&
        (fastest == nullptr || row.seconds.median < fastest->seconds.median)) {
      fastest = &row;
    }
  }
  return fastest;
}

std::string sentence_of(const Answer& answer) {
  const Row& pick = answer.pick;
  const auto size = [](const RenderSettings& s) {
    return std::to_string(s.width) + " x " + std::to_string(s.height);
  };
  const double pixels = static_cast<double>(pick.settings->width) * pick.settings->height;
  const double scale = static_cast<double>(answer.scene->width) * answer.scene->height / pixels;
  std::string text =
      "For an RMSE of " + formatted("%.3g", answer.error) +
      (answer.asked ? "" : ", that of the scene's own settings") + ": " +
      options_against(pick.settings, answer.scene) +
      (answer.own ? ", the scene's own settings with " +
                        counted(pick.settings->samples_per_pixel, "sample") + " per pixel"
                  : "") +
      " (" + formatted("%.3g s", pick.seconds.median) + " at " + size(pick.settings) +
      " on this machine";
  if (size(answer.scene) != size(pick.settings)) {
    text += ", about " + formatted("%.3g s", pick.seconds.median * scale) + " at the scene's " +
            size(answer.scene);
  }
  text += "; measured RMSE " + formatted("%.3g", pick.rmse) + " +- " +
          formatted("%.1g", pick.rmse_deviation) + ")";
  if (answer.own) return text + "; no other measured settings are faster.";
  if (answer.own_options.empty() || !(pick.seconds.median > 0)) return text + ".";
  return text + "; the scene's own settings" +
         (answer.asked ? " reach it with " + answer.own_options + " and " : " ") +
         times_text(answer.own_seconds / pick.seconds.median) + ".";
}

}  // namespace parray::tradeoff
