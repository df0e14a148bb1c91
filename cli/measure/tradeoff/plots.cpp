#include "cli/measure/tradeoff/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "cli/child_process/child_process.h"
#include "cli/measure/tradeoff/gnuplot.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::tradeoff {
namespace {

namespace fs = std::filesystem;

/// A way to draw with a marker.
std::string points(const std::string& with, int marker) {
  return with + " pt " + std::to_string(marker) + " ps 1";
}

/// "data index 2 using 1:2 with points ... title ...".
std::string curve(std::size_t block, const std::string& columns, const std::string& with,
                  const SeriesStyle& style, const std::string& title) {
  return "data index " + std::to_string(block) + " using " + columns + " with " + with +
         " lc rgb '" + style.colour + "' " + (title.empty() ? "notitle" : "title " + quoted(title));
}

std::string plot_of(const std::vector<std::string>& curves) {
  std::string text;
  for (const std::string& one : curves) text += (text.empty() ? "plot " : ", \\\n     ") + one;
  return text;
}

constexpr const char* error_axis = "set ylabel 'RMSE (linear radiance)'\n";

std::string seconds_axis(const Findings& findings) {
  return std::string("set xlabel 'time of a picture (s") +
         (findings.timing.busy ? " of processor / threads)'\n" : ")'\n");
}

Plot convergence_plot(const Findings& findings) {
  Plot plot{"convergence", "", ""};
  PlotData data;
  std::vector<std::string> curves;
  std::vector<double> samples;
  std::vector<double> errors;
  for (auto& [name, rows] : families_of(findings.rows, findings.base)) {
    std::erase_if(rows, [](const Row* row) { return !(row->rmse > 0); });
    if (rows.empty()) continue;
    std::ranges::sort(rows, {}, &Row::samples);
    data.block(name);
    for (const Row* row : rows) {
      data.line({row->samples, row->rmse, row->rmse_deviation});
      samples.push_back(row->samples);
      errors.push_back(row->rmse);
    }
    const SeriesStyle style = family_style(name);
    std::string title = name;
    const std::size_t block = data.blocks() - 1;
    for (const Convergence& one : findings.convergence) {
      if (one.name != name || !one.mse) continue;
      title += formatted(" (slope %.2f)", one.mse->slope / 2);
      data.block(name + ", power law");
      for (const Row* row : {rows.front(), rows.back()}) {
        data.line({row->samples, std::sqrt(one.mse->at(row->samples))});
      }
      curves.push_back(curve(data.blocks() - 1, "1:2", "lines", style, ""));
    }
    curves.push_back(curve(block, "1:2:3", points("yerrorbars", style.full), style, title));
  }
  const LogAxis x(samples, 0.05, 0.05);
  const LogAxis y(errors, 0.08, 0.08);
  plot.data = data.text();
  plot.commands =
      axes_commands(x, y) + "set xlabel 'samples a pixel'\n" + error_axis + plot_of(curves);
  return plot;
}

/// What tells a row from the others, in a few letters.
std::string label_of(const Row& row, const RenderSettings& base) {
  const RenderSettings& s = row.settings;
  std::string label = std::string(name_of(s.sampler)) +
                      (s.target_error > 0 ? " to " + formatted("%.2g", s.target_error)
                                          : " " + std::to_string(s.samples_per_pixel));
  if (s.max_depth != base.max_depth) label += ", depth " + std::to_string(s.max_depth);
  if (s.precision != base.precision) label += ", " + std::string(name_of(s.precision));
  if (s.accelerator != base.accelerator) label += ", " + std::string(name_of(s.accelerator));
  if (s.isa != base.isa) label += ", " + std::string(name_of(s.isa));
  return label + (s.replicates ? ", denoised" : "");
}

constexpr const char* other_family = "other depth, precision or search";

/// Rows that have an error, by family.
Families by_family(const Findings& findings) {
  Families families = families_of(findings.rows, findings.base);
  std::set<const Row*> known;
  for (auto& [name, rows] : families) {
    known.insert(rows.begin(), rows.end());
    std::erase_if(rows, [](const Row* row) { return !(row->rmse > 0); });
  }
  for (const Row& row : findings.rows) {
    if (row.rmse > 0 && !known.contains(&row)) families[other_family].push_back(&row);
  }
  return families;
}

NamedPoint point_of(const Row& row, const Findings& findings) {
  const bool own = row.knob == Knob::scene;
  return {row.seconds.median, row.rmse,
          (own ? "the scene's own: " : "") + label_of(row, findings.base)};
}

Plot front_plot(const Findings& findings) {
  Plot plot{"front", "", ""};
  PlotData data;
  std::vector<double> seconds;
  std::vector<double> errors;
  std::vector<NamedPoint> beneath;  // the front's names, in the corner where nothing is
  std::vector<NamedPoint> above;
  std::vector<NamedPoint> all;
  std::vector<const Row*> front;
  for (const auto& [name, rows] : by_family(findings)) {
    for (const Row* row : rows) {
      seconds.push_back(row->seconds.median);
      errors.push_back(row->rmse);
      const NamedPoint point = point_of(*row, findings);
      all.push_back(point);
      if (row->on_front) {
        front.push_back(row);
      } else if (row->knob == Knob::scene || row->knob == Knob::also) {
        above.push_back(point);
      }
    }
  }
  std::sort(front.begin(), front.end(),
            [](const Row* a, const Row* b) { return a->seconds.median < b->seconds.median; });
  beneath.reserve(front.size());
  for (const Row* row : front) beneath.push_back(point_of(*row, findings));
  data.block("the front");
  const auto add = [&](const Row& row) {
    data.line({row.seconds.median, row.rmse, row.seconds.q1, row.seconds.q3},
              options_against(row.settings, findings.scene));
  };
  for (const Row* row : front) add(*row);
  std::vector<std::string> curves = {
      "data index 0 using 1:2 with lines lw 1 lc rgb '#888888' title 'the front'"};
  for (const auto& [name, rows] : by_family(findings)) {
    const SeriesStyle style = family_style(name);
    for (const bool on_front : {false, true}) {
      if (std::ranges::none_of(rows, [&](const Row* row) { return row->on_front == on_front; })) {
        continue;
      }
      data.block(name + (on_front ? "" : ", dominated"));
      for (const Row* row : rows) {
        if (row->on_front == on_front) add(*row);
      }
      curves.push_back(curve(data.blocks() - 1, "1:2:3:4",
                             points("xerrorbars", on_front ? style.full : style.open), style, ""));
    }
    if (!rows.empty()) {
      curves.push_back("1/0 with points pt " + std::to_string(style.full) + " ps 1 lc rgb '" +
                       style.colour + "' title " + quoted(name));
    }
  }
  curves.emplace_back("1/0 with points pt 6 ps 1 lc rgb '#888888' title 'hollow: dominated'");
  const LogAxis x(seconds, 0.3, 0.05);
  const LogAxis y(errors, 0.2, 0.08);
  plot.data = data.text();
  plot.commands = axes_commands(x, y) + seconds_axis(findings) + error_axis +
                  name_commands(beneath, all, x, y, {-1, 0.7}) +
                  name_commands(above, all, x, y, {-0.2, -1}) + plot_of(curves);
  return plot;
}

Plot budget_plot(const Findings& findings) {
  Plot plot{"budget", "", "", 330};
  PlotData data;
  data.block("percent of the PNG's measured MSE: noise, depth, precision, 8 bits");
  for (const Row& row : findings.rows) {
    if (row.settings.accelerator != findings.base.accelerator || !(row.rmse_8bit > 0)) continue;
    const auto share = [&](double part) {
      const double ratio = part / row.rmse_8bit;
      return 100 * ratio * ratio;
    };
    const Budget& b = row.budget;
    data.line({share(b.monte_carlo), share(b.depth), share(b.precision), share(b.quantisation)},
              label_of(row, findings.base));
  }
  plot.data = data.text();
  plot.commands =
      "set style data histogram\nset style histogram rowstacked\nset boxwidth 0.8\n"
      "set key at screen 0.5, screen 0.1 center top horizontal maxcols 5\n"
      "set xtics rotate by 60 right\nset yrange [0:*]\n"
      "set ylabel \"part of the PNG's measured MSE (%)\"\n"
      "plot data using 1:xtic(5) fs solid lc rgb '#0072B2' title 'noise (stated)', \\\n"
      "     data using 2 fs pattern 4 lc rgb '#D55E00' title 'depth', \\\n"
      "     data using 3 fs pattern 5 lc rgb '#009E73' title 'precision', \\\n"
      "     data using 4 fs pattern 2 lc rgb '#E69F00' title '8 bits', \\\n"
      "     100 with lines lw 2 lc rgb 'black' title 'measured'";
  return plot;
}

Plot coverage_plot(const Findings& findings) {
  Plot plot{"coverage", "", ""};
  PlotData data;
  std::vector<std::string> curves = {"0 lc rgb '#888888' dt 2 title 'exact'"};
  // What is measured less what is stated, with the standard error that independent runs have.
  const auto add = [&](const std::string& name, const ByLevel& shares, std::size_t runs,
                       double shift) {
    data.block(name);
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const double level = interval_levels.at(i);
      const double scatter = std::sqrt(level * (1 - level) / static_cast<double>(runs));
      data.line({100 * level + shift, 100 * (shares.at(i) - level), 100 * scatter});
    }
    return data.blocks() - 1;
  };
  std::size_t number = 0;
  for (const Calibration& one : findings.calibration) {
    if (one.pixel_runs == 0) continue;
    const SeriesStyle style = one.name == "all" ? series_style(6) : family_style(one.name);
    curves.push_back(curve(add(one.name, one.pixels, 1, 0), "1:2",
                           points("linespoints", style.full), style, "pixels, " + one.name));
  }
  for (const Calibration& one : findings.calibration) {
    if (one.runs < 16 || (one.name != "all" && one.pixel_runs > 0)) continue;
    const SeriesStyle style = one.name == "all" ? series_style(6) : family_style(one.name);
    const double shift = 0.4 * static_cast<double>(++number);
    curves.push_back(curve(add(one.name, one.pictures, one.runs, shift), "1:2:3",
                           points("yerrorbars", style.open), style, "pictures' RMSE, " + one.name));
  }
  plot.data = data.text();
  plot.commands =
      "set xlabel 'intervals that should hold (%)'\n"
      "set ylabel 'intervals that hold, less those that should (percentage points)'\n"
      "set xrange [45:102]\nset yrange [*<-5:5<*]\n" +
      plot_of(curves);
  return plot;
}

/// The modelled fronts. A name stands right of the slowest farm's points: the same settings are at
/// the same height for all.
Plot farms_plot(const Findings& findings) {
  Plot plot{"farms", "", ""};
  PlotData data;
  std::vector<double> seconds;
  std::vector<double> errors;
  std::vector<NamedPoint> names;
  std::vector<NamedPoint> all;
  std::vector<std::string> curves;
  for (std::size_t i = 0; i < findings.farms.size(); ++i) {
    const FarmFront& farm = findings.farms[i];
    std::vector<FarmPoint> front = farm.points;
    std::erase_if(front, [](const FarmPoint& point) { return !point.on_front; });
    std::ranges::sort(front, {}, &FarmPoint::seconds);
    data.block(counted(farm.workers, "worker"));
    for (const FarmPoint& point : front) {
      const Row& row = findings.rows[point.row];
      data.line({point.seconds, point.rmse}, options_against(row.settings, findings.scene));
      seconds.push_back(point.seconds);
      errors.push_back(point.rmse);
      all.push_back({point.seconds, point.rmse, label_of(row, findings.base)});
      if (i == 0) names.push_back(all.back());
    }
    const SeriesStyle style = series_style(i);
    if (!front.empty()) {
      curves.push_back(curve(i, "1:2", points("linespoints", style.full), style,
                             counted(farm.workers, "worker")));
    }
  }
  const LogAxis x(seconds, 0.05, 0.3);
  const LogAxis y(errors, 0.08, 0.08);
  plot.data = data.text();
  plot.commands =
      axes_commands(x, y) + "set xlabel 'modelled, not measured: time of a picture of " +
      std::to_string(findings.scene.width) + " x " + std::to_string(findings.scene.height) +
      " pixels (s)'\n" + error_axis + name_commands(names, all, x, y, {1, -0.5}) + plot_of(curves);
  return plot;
}

std::vector<Plot> plots_of(const Findings& findings) {
  return {convergence_plot(findings), front_plot(findings), budget_plot(findings),
          coverage_plot(findings), farms_plot(findings)};
}

constexpr std::array names = {"convergence", "front", "budget", "coverage", "farms"};

}  // namespace

void write_plot_scripts(const Findings& findings, const fs::path& directory) {
  const fs::path plots = directory / "plots";
  fs::create_directories(plots);
  const std::string caption = caption_of(findings);
  for (const Plot& plot : plots_of(findings)) {
    write_text_file(plots / (plot.name + ".dat"), plot.data);
    write_text_file(plots / (plot.name + ".gp"), script_of(plot, caption));
  }
}

std::optional<std::string> draw_plots(const fs::path& directory, const std::string& path) {
  const auto gnuplot = find_program("gnuplot", path);
  if (!gnuplot) {
    return "no plots: gnuplot is missing (apt-get install gnuplot-nox); " +
           printable((directory / "plots").string(), 4096) + " has what it needs";
  }
  const fs::path plots = directory / "plots";
  for (const char* name : names) {
    const fs::path script = plots / (std::string(name) + ".gp");
    const fs::path log = plots / "gnuplot.log";
    const ChildEnd end =
        run_child({gnuplot->string(), "-c", script.string(), plots.string()}, {}, log, seconds(60));
    if (end.status != 0 || end.timed_out) {
      return "no plot " + std::string(name) + ": gnuplot failed, " + printable(log.string(), 4096) +
             " says why";
    }
    fs::remove(log);
  }
  return std::nullopt;
}

}  // namespace parray::tradeoff
