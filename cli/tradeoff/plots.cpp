#include "cli/tradeoff/plots.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "cli/output/text.h"
#include "cli/process/child_process.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/image/partial_file.h"

namespace parray::tradeoff {
namespace {

namespace fs = std::filesystem;

/// Blocks of lines, which gnuplot numbers from 0.
class Data {
 public:
  /// `name` is what `columnheader(1)` reads.
  void block(const std::string& name) {
    text_ += (text_.empty() ? "" : "\n\n") + quoted(name) + "\n";
  }
  void line(const std::vector<double>& values, const std::string& label = "") {
    std::string text;
    for (const double value : values) text += formatted("%.6g ", value);
    text_ += text + (label.empty() ? "" : quoted(label)) + "\n";
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static std::string quoted(const std::string& text) { return "\"" + text + "\""; }
  std::string text_;
};

struct Plot {
  std::string name;
  std::string data;
  std::string commands;  ///< from the settings of the axes to `plot`
  int width = 800;
  int height = 500;
};

std::string script_of(const Plot& plot) {
  const std::string size = std::to_string(plot.width) + "," + std::to_string(plot.height);
  return "# gnuplot " + plot.name + ".gp draws " + plot.name + ".svg and .png of " + plot.name +
         ".dat.\n"
         "if (ARGC > 0) cd ARG1\n"
         "set terminal svg size " +
         size +
         " font 'sans,12' background rgb 'white'\n"
         "set output '" +
         plot.name +
         ".svg'\n"
         "data = '" +
         plot.name +
         ".dat'\n"
         "set grid lc rgb '#dddddd'\n" +
         plot.commands + "\nset terminal pngcairo size " + size +
         " font 'sans,11'\n"
         "set output '" +
         plot.name + ".png'\nreplot\nset output\n";
}

// Okabe and Ito's colours, which people with any colour vision tell apart.
constexpr std::array colours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7"};

Plot convergence_plot(const Findings& findings) {
  Plot plot{"convergence", "", ""};
  Data data;
  std::string curves;
  std::size_t number = 0;
  for (auto& [name, rows] : families_of(findings.rows, findings.base)) {
    std::erase_if(rows, [](const Row* row) { return !(row->rmse > 0); });
    if (rows.empty()) continue;
    std::sort(rows.begin(), rows.end(),
              [](const Row* a, const Row* b) { return a->samples < b->samples; });
    data.block(name);
    for (const Row* row : rows) data.line({row->samples, row->rmse, row->rmse_deviation});
    const std::string colour = colours.at(number % colours.size());
    curves += (curves.empty() ? "plot " : ", \\\n     ") + std::string("data index ") +
              std::to_string(number) + " using 1:2:3 with yerrorbars pt 7 ps 0.7 lc rgb '" +
              colour + "' title '" + name + "'";
    for (const Convergence& one : findings.convergence) {
      if (one.name != name || !one.mse) continue;
      curves += formatted(", sqrt(exp(%.9g + %.9g", one.mse->intercept, one.mse->slope) +
                " * log(x))) lc rgb '" + colour + "' title " +
                formatted("'slope %.2f'", one.mse->slope / 2);
    }
    ++number;
  }
  plot.data = data.text();
  plot.commands =
      "set logscale xy\nset xlabel 'samples a pixel'\nset ylabel 'RMSE (linear radiance)'\n" +
      curves;
  return plot;
}

Plot front_plot(const Findings& findings) {
  Plot plot{"front", "", ""};
  Data data;
  std::vector<const Row*> front;
  for (const Row& row : findings.rows) {
    if (row.on_front) front.push_back(&row);
  }
  std::sort(front.begin(), front.end(),
            [](const Row* a, const Row* b) { return a->seconds.median < b->seconds.median; });
  const auto add = [&](const Row& row) {
    data.line({row.seconds.median, row.rmse, row.seconds.q1, row.seconds.q3},
              options_against(row.settings, findings.scene));
  };
  data.block("the front");
  for (const Row* row : front) add(*row);
  data.block("dominated");
  for (const Row& row : findings.rows) {
    if (!row.on_front) add(row);
  }
  std::string others;
  std::size_t number = 2;
  for (const Row& row : findings.rows) {
    if (row.knob != Knob::scene && row.knob != Knob::also) continue;
    const bool own = row.knob == Knob::scene;
    const std::string name =
        own ? "the scene's own settings" : options_against(row.settings, findings.scene);
    data.block(name);
    add(row);
    others += ", \\\n     data index " + std::to_string(number) +
              " using 1:2 with points pt 6 ps 2 lw 2 lc rgb '" +
              colours.at((number - 1) % colours.size()) + "' title \"" + name + "\"";
    ++number;
  }
  plot.data = data.text();
  plot.commands =
      "set logscale xy\nset key bmargin center vertical Left reverse maxrows 8 width -12 font "
      "',10'\nset xlabel 'seconds'\nset ylabel 'RMSE (linear radiance)'\n"
      "plot data index 1 using 1:2 with points pt 2 lc rgb '#999999' title 'dominated', \\\n"
      "     data index 0 using 1:2:3:4 with xerrorbars pt 7 ps 0.7 lc rgb '#0072B2' notitle, \\\n"
      "     data index 0 using 1:2 with lines lw 2 lc rgb '#0072B2' title 'the front'" +
      others;
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
  return label;
}

Plot budget_plot(const Findings& findings) {
  Plot plot{"budget", "", "", 1000, 600};
  Data data;
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
      "set style fill solid\nset bmargin 9\nset xtics rotate by 60 right font 'sans,9'\nset yrange "
      "[0:*]\n"
      "set ylabel \"part of the PNG's measured MSE (%)\"\nset key outside top horizontal\n"
      "plot data using 1:xtic(5) lc rgb '#56B4E9' title 'noise', \\\n"
      "     data using 2 lc rgb '#D55E00' title 'depth', \\\n"
      "     data using 3 lc rgb '#009E73' title 'precision', \\\n"
      "     data using 4 lc rgb '#F0E442' title '8 bits', \\\n"
      "     100 with lines lw 2 lc rgb 'black' title 'measured'";
  return plot;
}

Plot coverage_plot(const Findings& findings) {
  Plot plot{"coverage", "", "", 600, 500};
  Data data;
  std::string curves = "plot x lc rgb '#999999' dt 2 title 'exact'";
  std::size_t number = 0;
  for (const Calibration& one : findings.calibration) {
    data.block(one.name);
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      data.line({100 * interval_levels.at(i), 100 * one.pixels.at(i)});
    }
    curves += ", \\\n     data index " + std::to_string(number) +
              " using 1:2 with linespoints pt 7 ps 0.7 title '" + one.name + "'";
    ++number;
  }
  plot.data = data.text();
  plot.commands =
      "set xlabel 'stated: intervals that hold (%)'\nset ylabel 'measured (%)'\n"
      "set xrange [45:100]\nset yrange [45:100]\nset key top left\n" +
      curves;
  return plot;
}

std::vector<Plot> plots_of(const Findings& findings) {
  return {convergence_plot(findings), front_plot(findings), budget_plot(findings),
          coverage_plot(findings)};
}

constexpr std::array names = {"convergence", "front", "budget", "coverage"};

}  // namespace

void write_plot_scripts(const Findings& findings, const fs::path& directory) {
  const fs::path plots = directory / "plots";
  fs::create_directories(plots);
  for (const Plot& plot : plots_of(findings)) {
    write_text_file(plots / (plot.name + ".dat"), plot.data);
    write_text_file(plots / (plot.name + ".gp"), script_of(plot));
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
