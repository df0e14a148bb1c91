#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/bench.h"

namespace parray::tradeoff {

/// The predicted picture with the settings of a row, in the size that the scene states.
struct FarmPoint {
  std::size_t row = 0;  ///< index of the row
  double seconds = 0;   ///< predicted wall-clock time
  double rmse = 0;      ///< Row::rmse
  bool on_front = false;
};

/// The Pareto front of a farm. Modelled, not measured.
struct FarmFront {
  std::uint32_t workers = 0;        ///< workers as fast as this machine
  std::vector<FarmPoint> points{};  ///< rows with a known error
};

/// Returns the fronts for 1, 4, 16 and 64 workers of `threads` threads. Scales the time of each row
/// to the number of pixels of `scene` and replays the coordinator's lease rules in virtual time
/// (FarmModel, cli/measure/plan/plan.h), in the row's number of passes. Leaves out the network. One
/// machine denoises.
std::vector<FarmFront> farm_fronts_of(const std::vector<Row>& rows, const RenderSettings& scene,
                                      int threads);

/// How the error of one family falls with samples. A family has one sampler and one way to place
/// samples, with or without denoising: see Families.
struct Convergence {
  std::string name;             ///< "independent", "sobol, adaptive, denoised"
  std::optional<PowerLaw> mse;  ///< as a function of samples per pixel
  double equal_time_gain =
      0;  ///< MSE of independent samples divided by this MSE, in the same time; 0: unknown
};

/// How often confidence intervals hold, which means that they contain the true value.
struct Calibration {
  std::string name;  ///< "all" (without denoised pictures), or the name of a family
  ByLevel pixels{};  ///< shares of intervals that hold, over all pixels, channels and runs
  std::size_t pixel_runs = 0;  ///< 0 for denoised pictures
  ByLevel pictures{};          ///< shares of runs whose interval of the RMSE holds
  std::size_t runs = 0;
};

/// Machine and date of the measurements.
struct Environment {
  std::string processor;  ///< its model
  std::string isa;        ///< instruction set of the scene's own settings on this machine
  std::string date;       ///< date of the last measurement: "2026-11-22"
};

/// All results of `parray tradeoff`.
struct TradeoffResults {
  std::string scene_file;
  std::size_t spheres = 0;
  Environment environment;
  Boxed<RenderSettings> scene;  ///< the scene's own settings and size
  Boxed<RenderSettings> base;   ///< the same with the measured size
  Timing timing;
  std::vector<Row> rows;
  PairedBiases biases;
  std::vector<Convergence> convergence;
  std::vector<Calibration> calibration;
  std::vector<FarmFront> farms;       ///< modelled
  double reference_samples = 0;       ///< Reference::samples()
  double reference_rmse = 0;          ///< Reference::rmse()
  std::vector<std::string> left_out;  ///< settings that were not measured, by options_of()
  std::vector<std::string> notes;     ///< sentences about limits of these results
  std::string answer;                 ///< sentence_of() the answer
  nlohmann::json answer_facts;        ///< the same for scripts
};

/// Rows with the scene's own depth, precision, accelerator and instruction set, by their kind of
/// samples. The keys are the names of Convergence.
using Families = std::map<std::string, std::vector<const Row*>>;
Families families_of(const std::vector<Row>& rows, const RenderSettings& base);

/// Returns the rows of `runs` in the order of `variants`, with error budgets and the Pareto front.
/// Leaves out variants without runs.
std::vector<Row> rows_of(const std::vector<Variant>& variants, const std::vector<Run>& runs,
                         const PairedBiases& biases, const Timing& timing);
/// Returns how the error falls with samples, for each family.
std::vector<Convergence> convergence_of(const std::vector<Row>& rows, const RenderSettings& base);
/// Returns how often confidence intervals hold, for each family and for all. Leaves out rows that
/// share their noise with others (depths, precisions, accelerators), and rows whose systematic
/// error is above a fifth of the Monte Carlo error.
std::vector<Calibration> calibration_of(const std::vector<Row>& rows);

// CSV tables with a header, for the plots. The functions remove the commas from names.
/// Returns the table of the rows.
std::string csv_of(const TradeoffResults& results);
/// Returns the table of the modelled Pareto fronts of farms.
std::string farms_csv_of(const TradeoffResults& results);
/// Returns the table of Calibration: how often confidence intervals hold.
std::string intervals_csv_of(const TradeoffResults& results);
/// Returns all results, for scripts.
nlohmann::json json_of(const TradeoffResults& results);
/// Returns the tables for people, without the answer.
std::string text_of(const TradeoffResults& results);

// Plots of these tables in the directory DIR of measurements. The program contains their scripts
// for gnuplot.

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
