#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/measure/tradeoff/findings.h"

namespace parray::tradeoff {

/// Writes DIR/plots/{convergence,front,budget,coverage,farms}.{dat,gp}: data, and scripts that
/// gnuplot makes SVG, PDF and PNG of (in that directory: `gnuplot front.gp`).
void write_plot_scripts(const Findings& findings, const std::filesystem::path& directory);

/// Runs gnuplot, found in the directories of `path`, on them. Returns a line for people when there
/// are no plots to look at. Throws Interrupted.
std::optional<std::string> draw_plots(const std::filesystem::path& directory,
                                      const std::string& path);

}  // namespace parray::tradeoff
