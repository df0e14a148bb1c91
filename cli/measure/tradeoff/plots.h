#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/measure/tradeoff/tradeoff_results.h"

/// Plots of the tables in DIR. Their scripts are plots/*.gp, which the program contains.
namespace parray::tradeoff {

/// One line below each plot: the scene, the machine, the version and the date.
std::string caption_of(const TradeoffResults& results);

/// Writes gnuplot's scripts to DIR/plots. They read DIR/tradeoff.csv, farms.csv and intervals.csv
/// and draw {convergence,front,budget,coverage,farms}.{svg,pdf,png} (in DIR/plots: `gnuplot
/// front.gp`).
void write_plot_scripts(const TradeoffResults& results, const std::filesystem::path& directory);

/// Runs gnuplot on the scripts. Looks for it in the directories of `path`. Returns a message if
/// a plot is missing. Throws Interrupted.
std::optional<std::string> draw_plots(const std::filesystem::path& directory,
                                      const std::string& path);

}  // namespace parray::tradeoff
