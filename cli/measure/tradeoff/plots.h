#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "cli/measure/tradeoff/tradeoff_results.h"

/// Plots of the tables in the directory DIR of measurements. The program contains their scripts for
/// gnuplot.
namespace parray::tradeoff {

/// A file plots/NAME.gp of the source. CMake writes plot_scripts.cpp, which contains their texts.
struct PlotScript {
  std::string_view name;
  std::string_view text;
};
extern const std::array<PlotScript, 7> plot_scripts;

/// Returns the line below each plot: the scene, the machine, the version and the date.
std::string caption_of(const TradeoffResults& results);

/// Writes gnuplot's scripts to DIR/plots. `directory` is DIR. The scripts read DIR/tradeoff.csv,
/// farms.csv and intervals.csv and draw {convergence,front,budget,coverage,farms}.{svg,pdf,png} (in
/// DIR/plots: `gnuplot front.gp`). Throws RunError if a file cannot be written.
void write_plot_scripts(const TradeoffResults& results, const std::filesystem::path& directory);

/// Runs gnuplot on the scripts, at most 60 s for each. Looks for gnuplot in the directories of
/// `path` ("/usr/bin:/bin"). Returns a message for the user if a plot is missing. Throws
/// Interrupted.
std::optional<std::string> draw_plots(const std::filesystem::path& directory,
                                      const std::string& path);

}  // namespace parray::tradeoff
