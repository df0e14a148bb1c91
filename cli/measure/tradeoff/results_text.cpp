// Results as tables for people, and as CSV and JSON for scripts.
#include <algorithm>
#include <functional>
#include <map>

#include "cli/measure/tradeoff/tradeoff_results.h"
#include "cli/output/text.h"
#include "common/base/printable.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

using nlohmann::json;

/// A value of a row, with its name in CSV and JSON.
struct Field {
  const char* name;
  std::function<json(const Row&)> value;
};

/// Returns the coverage of pixels' intervals. Denoised pictures have none.
json coverage_of(const Row& row, std::size_t level) {
  return row.settings->replicates ? json() : json(row.coverage.at(level));
}

const std::vector<Field>& fields() {
  static const std::vector<Field> all = {
      {"options", [](const Row& r) { return r.options; }},
      {"knob", [](const Row& r) { return name_of(r.varied); }},
      {"sampler", [](const Row& r) { return name_of(r.settings->sampler); }},
      {"adaptive", [](const Row& r) { return r.settings->adaptive; }},
      {"denoised", [](const Row& r) { return r.settings->replicates; }},
      {"target_error", [](const Row& r) { return r.settings->target_error; }},
      {"max_depth", [](const Row& r) { return r.settings->max_depth; }},
      {"precision", [](const Row& r) { return name_of(r.settings->precision); }},
      {"accelerator", [](const Row& r) { return name_of(r.settings->accelerator); }},
      {"runs", [](const Row& r) { return r.runs; }},
      {"samples_per_pixel", [](const Row& r) { return r.samples; }},
      {"passes", [](const Row& r) { return r.passes; }},
      {"rays_per_sample", [](const Row& r) { return r.rays; }},
      {"seconds", [](const Row& r) { return r.seconds.median; }},
      {"seconds_q1", [](const Row& r) { return r.seconds.q1; }},
      {"seconds_q3", [](const Row& r) { return r.seconds.q3; }},
      {"denoise_seconds", [](const Row& r) { return r.denoise_seconds; }},
      {"cpu_seconds", [](const Row& r) { return r.cpu_seconds; }},
      {"mse", [](const Row& r) { return r.mse; }},
      {"mse_scatter", [](const Row& r) { return r.mse_scatter; }},
      {"mse_sd", [](const Row& r) { return r.mse_deviation; }},
      {"rmse", [](const Row& r) { return r.rmse; }},
      {"rmse_sd", [](const Row& r) { return r.rmse_deviation; }},
      {"bias", [](const Row& r) { return r.bias; }},
      {"claimed_rmse", [](const Row& r) { return r.claimed; }},
      {"claims_held", [](const Row& r) { return r.claims[stated_level]; }},
      {"claims_50", [](const Row& r) { return r.claims[0]; }},
      {"claims_80", [](const Row& r) { return r.claims[1]; }},
      {"claims_90", [](const Row& r) { return r.claims[2]; }},
      {"claims_99", [](const Row& r) { return r.claims[4]; }},
      {"eps_mc", [](const Row& r) { return r.budget.monte_carlo; }},
      {"eps_depth", [](const Row& r) { return r.budget.depth; }},
      {"depth_bound", [](const Row& r) { return r.truncation; }},
      {"eps_precision", [](const Row& r) { return r.budget.precision; }},
      {"eps_quantisation", [](const Row& r) { return r.budget.quantisation; }},
      {"predicted_rmse", [](const Row& r) { return r.budget.predicted(); }},
      {"predicted_to_rmse", [](const Row& r) { return r.ratio(); }},
      {"rmse_8bit", [](const Row& r) { return r.rmse_8bit; }},
      {"predicted_rmse_8bit", [](const Row& r) { return r.budget.predicted_8bit(); }},
      {"predicted_to_rmse_8bit", [](const Row& r) { return r.ratio_8bit(); }},
      {"coverage_50", [](const Row& r) { return coverage_of(r, 0); }},
      {"coverage_80", [](const Row& r) { return coverage_of(r, 1); }},
      {"coverage_90", [](const Row& r) { return coverage_of(r, 2); }},
      {"coverage_95", [](const Row& r) { return coverage_of(r, 3); }},
      {"coverage_99", [](const Row& r) { return coverage_of(r, 4); }},
      {"efficiency", [](const Row& r) { return r.efficiency(); }},
      {"on_front", [](const Row& r) { return r.on_front; }},
      {"dominated_by", [](const Row& r) { return r.dominated_by; }}};
  return all;
}

std::string cell_of(const json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return formatted("%.9g", value.get<double>());
}

std::string without_commas(std::string text) {
  std::erase(text, ',');
  return text;
}

/// The differences between settings in a few words: "sobol 16 depth 5".
std::string name_in_plots(const RenderSettings& s, const RenderSettings& base) {
  std::string name = std::string(name_of(s.sampler)) +
                     (s.target_error > 0 ? " to " + formatted("%.2g", s.target_error)
                                         : " " + std::to_string(s.samples_per_pixel));
  if (s.max_depth != base.max_depth) name += " depth " + std::to_string(s.max_depth);
  if (s.precision != base.precision) name += " " + std::string(name_of(s.precision));
  if (s.accelerator != base.accelerator) name += " " + std::string(name_of(s.accelerator));
  if (s.isa != base.isa) name += " " + std::string(name_of(s.isa));
  return name + (s.replicates ? " denoised" : "");
}

std::string rough(double value) { return formatted("%.3g", value); }

std::string front_text(const TradeoffResults& results) {
  std::vector<const Row*> front;
  for (const Row& row : results.rows) {
    if (row.on_front) front.push_back(&row);
  }
  std::ranges::sort(front, {}, [](const Row* row) { return row->seconds.median; });
  std::vector<std::vector<std::string>> cells;
  for (const Row* row : front) {
    const Budget& budget = row->budget;
    cells.push_back({rough(row->seconds.median), formatted("%.1f", row->samples), rough(row->rmse),
                     rough(budget.monte_carlo), rough(budget.depth), rough(budget.precision),
                     formatted("%.3f", row->ratio()), rough(row->rmse_8bit),
                     formatted("%.3f", row->ratio_8bit()),
                     options_against(row->settings, results.scene)});
  }
  return table_text({"seconds", "spp", "RMSE", "noise", "depth", "precision", "predicted",
                     "RMSE PNG", "predicted", "settings"},
                    cells);
}

std::string convergence_text(const TradeoffResults& results) {
  std::vector<std::vector<std::string>> cells;
  for (const Convergence& one : results.convergence) {
    cells.push_back(
        {one.name, one.mse ? formatted("%.3f +- %.3f", one.mse->slope, one.mse->slope_error) : "-",
         one.equal_time_gain > 0 ? formatted("%.2f", one.equal_time_gain) : "-"});
  }
  return table_text({"samples", "slope of MSE", "MSE gain in equal time"}, cells);
}

std::string calibration_text(const TradeoffResults& results) {
  std::vector<std::vector<std::string>> cells;
  const auto add = [&](const std::string& name, const ByLevel& shares, std::size_t runs) {
    if (runs == 0) return;
    std::vector<std::string> line = {name};
    for (const double share : shares) line.push_back(formatted("%.1f %%", 100 * share));
    line.push_back(std::to_string(runs));
    cells.push_back(line);
  };
  for (const Calibration& one : results.calibration) {
    add(one.name + ": pixels", one.pixels, one.pixel_runs);
    add(one.name + ": pictures", one.pictures, one.runs);
  }
  return table_text({"intervals that hold", "50 %", "80 %", "90 %", "95 %", "99 %", "runs"}, cells);
}

/// Returns the table of farms: the time of each point on the front, for each number of workers.
std::string farms_text(const TradeoffResults& results) {
  std::vector<std::string> header = {"RMSE"};
  for (const FarmFront& farm : results.farms) header.push_back(counted(farm.workers, "worker"));
  header.emplace_back("settings");
  std::map<double, std::vector<std::string>, std::greater<>> lines;
  for (std::size_t farm = 0; farm < results.farms.size(); ++farm) {
    for (const FarmPoint& point : results.farms[farm].points) {
      if (!point.on_front) continue;
      std::vector<std::string>& line = lines[point.rmse];
      line.resize(header.size(), "-");
      line.front() = rough(point.rmse);
      line[farm + 1] = rough(point.seconds);
      line.back() = options_against(results.rows[point.row].settings, results.scene);
    }
  }
  std::vector<std::vector<std::string>> cells;
  cells.reserve(lines.size());
  for (const auto& [rmse, line] : lines) cells.push_back(line);
  return table_text(header, cells);
}

json json_of(const RenderSettings& settings) {
  return {{"options", options_of(settings)},
          {"width", settings.width},
          {"height", settings.height},
          {"seed", settings.seed}};
}

}  // namespace

std::string farms_csv_of(const TradeoffResults& results) {
  std::string text = "workers,options,modelled_seconds,rmse,on_front,name\n";
  for (const FarmFront& farm : results.farms) {
    for (const FarmPoint& point : farm.points) {
      text += std::to_string(farm.workers) + "," + results.rows[point.row].options +
              formatted(",%.9g,%.9g", point.seconds, point.rmse) +
              (point.on_front ? ",1," : ",0,") +
              name_in_plots(results.rows[point.row].settings, results.base) + "\n";
    }
  }
  return text;
}

std::string intervals_csv_of(const TradeoffResults& results) {
  std::string text = "intervals,nominal,pixels,pixel_runs,pictures,runs\n";
  for (const Calibration& one : results.calibration) {
    for (std::size_t i = 0; i < interval_levels.size(); ++i) {
      text += without_commas(one.name) + formatted(",%.9g,", interval_levels.at(i)) +
              (one.pixel_runs > 0 ? formatted("%.9g", one.pixels.at(i)) : "") +
              formatted(",%zu,%.9g,%zu\n", one.pixel_runs, one.pictures.at(i), one.runs);
    }
  }
  return text;
}

std::string csv_of(const TradeoffResults& results) {
  std::map<const Row*, std::string> families;
  for (const auto& [name, rows] : families_of(results.rows, results.base)) {
    for (const Row* row : rows) families[row] = without_commas(name);
  }
  std::string text;
  for (const Field& field : fields()) text += std::string(field.name) + ",";
  text += "family,name\n";
  for (const Row& row : results.rows) {
    for (const Field& field : fields()) text += cell_of(field.value(row)) + ",";
    const auto family = families.find(&row);
    text += (family == families.end() ? "other" : family->second) + "," +
            name_in_plots(row.settings, results.base) + "\n";
  }
  return text;
}

json json_of(const TradeoffResults& results) {
  json rows = json::array();
  for (const Row& row : results.rows) {
    json one = json::object();
    for (const Field& field : fields()) one[field.name] = field.value(row);
    rows.push_back(std::move(one));
  }
  json convergence = json::array();
  for (const Convergence& one : results.convergence) {
    const PowerLaw law = one.mse.value_or(PowerLaw());
    convergence.push_back({{"samples", one.name},
                           {"mse_slope", one.mse ? json(law.slope) : json()},
                           {"mse_slope_error", one.mse ? json(law.slope_error) : json()},
                           {"mse_intercept", one.mse ? json(law.intercept) : json()},
                           {"equal_time_gain", one.equal_time_gain}});
  }
  json calibration = json::array();
  for (const Calibration& one : results.calibration) {
    calibration.push_back({{"intervals", one.name},
                           {"nominal", interval_levels},
                           {"pixels", one.pixel_runs > 0 ? json(one.pixels) : json()},
                           {"pixel_runs", one.pixel_runs},
                           {"pictures", one.pictures},
                           {"runs", one.runs}});
  }
  json farms = json::array();
  for (const FarmFront& farm : results.farms) {
    json points = json::array();
    for (const FarmPoint& point : farm.points) {
      points.push_back({{"options", results.rows[point.row].options},
                        {"modelled_seconds", point.seconds},
                        {"rmse", point.rmse},
                        {"on_front", point.on_front}});
    }
    farms.push_back({{"workers", farm.workers}, {"points", points}});
  }
  return {{"version", PARRAY_VERSION},
          {"scene", results.scene_file},
          {"spheres", results.spheres},
          {"processor", results.environment.processor},
          {"isa", results.environment.isa},
          {"date", results.environment.date},
          {"scene_settings", json_of(results.scene)},
          {"measured_settings", json_of(results.base)},
          {"threads", results.timing.threads},
          {"time", results.timing.busy ? "cpu / threads" : "wall"},
          {"reference",
           {{"samples_per_pixel", results.reference_samples}, {"rmse", results.reference_rmse}}},
          {"rows", rows},
          {"biases", to_json(results.biases)},
          {"convergence", convergence},
          {"calibration", calibration},
          {"farms", farms},
          {"left_out", results.left_out},
          {"notes", results.notes},
          {"answer", results.answer_facts},
          {"sentence", results.answer}};
}

std::string text_of(const TradeoffResults& results) {
  const RenderSettings& base = results.base;
  std::string text = printable(results.scene_file, 500) + ": " + std::to_string(base.width) +
                     " x " + std::to_string(base.height) + " pixels, " +
                     counted(static_cast<std::uint64_t>(results.timing.threads), "thread") + ", " +
                     counted(results.rows.size(), "setting") + " measured against " +
                     formatted("%.0f", results.reference_samples) + " samples per pixel (RMSE " +
                     rough(results.reference_rmse) + ", subtracted)\n\n";
  text += "Pareto-optimal settings (nothing measured was both faster and as accurate):\n\n" +
          front_text(results);
  text +=
      "\nRMSE: of linear radiance. noise, depth, precision: parts of the RMSE, measured "
      "separately.\n"
      "predicted: root of the sum of the squares of these parts, divided by the RMSE.\n"
      "RMSE PNG, and predicted after it: the same with the error of 8-bit files.\n\n";
  text += convergence_text(results) + "\n" + calibration_text(results);
  text += "\nModelled, not measured: seconds for a picture of " +
          std::to_string(results.scene->width) + " x " + std::to_string(results.scene->height) +
          " pixels with workers as fast as this machine,\nwith the coordinator's rules for leases, "
          "without network. \"-\": other settings are faster and as accurate.\n\n" +
          farms_text(results);
  for (const std::string& note : results.notes) text += "\nNote: " + note;
  return text + (results.notes.empty() ? "" : "\n");
}

}  // namespace parray::tradeoff
