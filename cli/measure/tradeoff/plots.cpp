#include <system_error>

#include "cli/child_process/child_process.h"
#include "cli/measure/tradeoff/tradeoff_results.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/processor.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::tradeoff {
namespace {

namespace fs = std::filesystem;

/// Returns a text as a string of gnuplot.
std::string quoted(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '\'' ? std::string("''") : std::string(1, c);
  return "'" + safe + "'";
}

/// Returns the file values.gp: texts of the plots that depend on the scene and the machine.
std::string values_of(const TradeoffResults& results) {
  return "caption = " + quoted(caption_of(results)) + "\ntime_axis = 'time of a picture (s" +
         (results.timing.busy ? " of processor / threads" : "") +
         ")'\nfarm_axis = 'modelled, not measured: time of a picture of " +
         std::to_string(width_of(results.scene)) + " x " +
         std::to_string(height_of(results.scene)) + " pixels (s)'\n";
}

}  // namespace

std::string caption_of(const TradeoffResults& results) {
  const std::string name = fs::path(results.scene_file).stem().string();
  return printable(name, 40) + ", " + counted(results.spheres, "sphere") + ", " +
         std::to_string(width_of(results.base)) + " x " + std::to_string(height_of(results.base)) +
         " pixels; " + short_processor(results.environment.processor).substr(0, 40) + ", " +
         counted(static_cast<std::uint64_t>(results.timing.threads), "thread") + ", " +
         results.environment.isa + "; ParRay " PARRAY_VERSION ", " + results.environment.date;
}

void write_plot_scripts(const TradeoffResults& results, const fs::path& directory) {
  const fs::path plots = directory / "plots";
  std::error_code ignored;  // without the directory, writing the first file fails with a reason
  fs::create_directories(plots, ignored);
  write_text_file(plots / "values.gp", values_of(results));
  for (const PlotScript& script : plot_scripts) {
    write_text_file(plots / (std::string(script.name) + ".gp"), std::string(script.text));
  }
}

std::optional<std::string> draw_plots(const fs::path& directory, const std::string& path) {
  const auto gnuplot = find_program("gnuplot", path);
  if (!gnuplot) {
    return "no plots: gnuplot is missing (apt-get install gnuplot-nox); " +
           printable((directory / "plots").string(), 4096) + " has the scripts for it";
  }
  const fs::path plots = directory / "plots";
  for (const char* name : {"convergence", "front", "budget", "coverage", "farms"}) {
    const fs::path script = plots / (std::string(name) + ".gp");
    const fs::path log = plots / "gnuplot.log";
    const ChildEnd end =
        run_child({gnuplot->string(), "-c", script.string(), plots.string()}, {}, log, seconds(60));
    if (end.status != 0 || end.timed_out) {
      return "no plot " + std::string(name) + ": gnuplot " +
             (end.timed_out ? "took longer than 60 s"
                            : "failed, " + printable(log.string(), 4096) + " has the reason");
    }
    std::error_code ignored;  // the plot exists
    fs::remove(log, ignored);
  }
  return std::nullopt;
}

}  // namespace parray::tradeoff
