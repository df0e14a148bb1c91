#include "cli/measure/tradeoff/tradeoff_results.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/measure/plan/plan.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

constexpr std::array<std::uint32_t, 4> farm_sizes = {1, 4, 16, 64};

double seconds_of(const Row& row, const RenderSettings& scene, std::uint32_t workers, int threads) {
  RenderSettings settings = row.settings;
  settings.width = scene.width;
  settings.height = scene.height;
  const FarmModel farm(settings, std::vector<double>(workers, 1),
                       static_cast<std::uint32_t>(threads));
  const double larger = pixels_of(settings) / pixels_of(row.settings);
  const int passes = std::max(static_cast<int>(std::lround(row.passes)), 1);
  return farm.seconds(larger * (row.seconds.median - row.denoise_seconds), row.samples, passes) +
         larger * row.denoise_seconds;
}

std::string family_of(const RenderSettings& settings) {
  return std::string(name_of(settings.sampler)) + (settings.adaptive ? ", adaptive" : "") +
         (settings.replicates ? ", denoised" : "");
}

/// Returns the MSE as a function of seconds.
LogCurve over_time(const std::vector<const Row*>& rows) {
  std::vector<std::pair<double, double>> points;
  points.reserve(rows.size());
  for (const Row* row : rows) points.emplace_back(row->seconds.median, row->mse);
  return LogCurve(points);
}

/// Returns the gain in MSE in the same time, at the logarithmic middle of the times at which both
/// were measured. 0: unknown.
double gain_of(const std::vector<const Row*>& rows, const std::vector<const Row*>& independent) {
  const LogCurve ours = over_time(rows);
  const LogCurve theirs = over_time(independent);
  if (!ours.known() || !theirs.known()) return 0;
  const auto range = [](const std::vector<const Row*>& of) {
    const auto [least, most] =
        std::ranges::minmax_element(of, {}, [](const Row* row) { return row->seconds.median; });
    return std::pair{(*least)->seconds.median, (*most)->seconds.median};
  };
  const auto [a, b] = range(rows);
  const auto [c, d] = range(independent);
  const double from = std::max(a, c);
  const double to = std::min(b, d);
  if (!(from > 0) || !(from <= to)) return 0;
  const double middle = std::sqrt(from * to);
  return theirs.at(middle) / ours.at(middle);
}

}  // namespace

std::vector<FarmFront> farm_fronts_of(const std::vector<Row>& rows, const RenderSettings& scene,
                                      int threads) {
  std::vector<FarmFront> fronts;
  for (const std::uint32_t workers : farm_sizes) {
    FarmFront front{workers};
    std::vector<CostAndError> costs;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!(rows[i].rmse > 0)) continue;
      const double seconds = seconds_of(rows[i], scene, workers, threads);
      front.points.push_back({i, seconds, rows[i].rmse});
      costs.push_back({seconds, rows[i].rmse});
    }
    const std::vector<std::size_t> dominators = dominators_of(costs);
    for (std::size_t i = 0; i < costs.size(); ++i) front.points[i].on_front = dominators[i] == i;
    fronts.push_back(std::move(front));
  }
  return fronts;
}

Families families_of(const std::vector<Row>& rows, const RenderSettings& base) {
  Families families;
  for (const Row& row : rows) {
    const RenderSettings& s = row.settings;
    if (s.max_depth == base.max_depth && s.precision == base.precision &&
        s.accelerator == base.accelerator && s.isa == base.isa) {
      families[family_of(s)].push_back(&row);
    }
  }
  return families;
}

std::vector<Row> rows_of(const std::vector<Variant>& variants, const std::vector<Run>& runs,
                         const PairedBiases& biases, const Timing& timing) {
  std::map<std::string, std::vector<const Run*>> by_options;
  for (const Run& run : runs) by_options[run.options].push_back(&run);
  std::vector<Row> rows;
  for (const Variant& variant : variants) {
    const auto found = by_options.find(options_of(variant.settings));
    if (found == by_options.end()) continue;
    Row row = row_of(variant, found->second, timing);
    by_options.erase(found);  // a variant listed twice is one row
    if (const auto bias = biases.depth.find(row.settings->max_depth); bias != biases.depth.end()) {
      row.budget.depth = bias->second.rms();
    }
    if (const auto bias = biases.precision.find(row.settings->precision);
        bias != biases.precision.end()) {
      row.budget.precision = bias->second.rms();
    }
    rows.push_back(std::move(row));
  }
  mark_front(rows);
  return rows;
}

std::vector<Convergence> convergence_of(const std::vector<Row>& rows, const RenderSettings& base) {
  const auto families = families_of(rows, base);
  const auto independent = families.find(std::string(name_of(Sampler::independent)));
  std::vector<Convergence> found;
  for (const auto& [name, members] : families) {
    std::vector<std::pair<double, double>> points;
    for (const Row* row : members) points.emplace_back(row->samples, row->mse);
    found.push_back({name, fit_power_law(points),
                     independent == families.end() ? 0 : gain_of(members, independent->second)});
  }
  return found;
}

std::vector<Calibration> calibration_of(const std::vector<Row>& rows) {
  std::map<std::string, Calibration> by_name;
  const auto add = [&](const std::string& name, const Row& row) {
    Calibration& one = by_name[name];
    one.name = name;
    const bool pixels = !row.settings->replicates;
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      one.pixels.at(i) += pixels ? row.coverage.at(i) * static_cast<double>(row.runs) : 0;
      one.pictures.at(i) += row.claims.at(i) * static_cast<double>(row.runs);
    }
    one.pixel_runs += pixels ? row.runs : 0;
    one.runs += row.runs;
  };
  for (const Row& row : rows) {
    // These rows share their random numbers with other rows, so they are not independent.
    if (row.varied == VariedSetting::depth || row.varied == VariedSetting::precision ||
        row.varied == VariedSetting::accelerator) {
      continue;
    }
    // Intervals do not cover systematic errors. One of less than a fifth hardly matters.
    const double systematic = std::hypot(row.budget.depth, row.budget.precision);
    if (systematic > 0.2 * row.budget.monte_carlo) continue;
    if (!row.settings->replicates) add("all", row);
    add(family_of(row.settings), row);
  }
  std::vector<Calibration> found;
  for (auto& [name, one] : by_name) {
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      if (one.pixel_runs > 0) one.pixels.at(i) /= static_cast<double>(one.pixel_runs);
      one.pictures.at(i) /= static_cast<double>(one.runs);
    }
    found.push_back(one);
  }
  return found;
}

}  // namespace parray::tradeoff
