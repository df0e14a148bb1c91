#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/farm_fronts.h"
#include "cli/measure/tradeoff/paired.h"

namespace parray::tradeoff {

/// How the error falls with samples, of one sampler.
struct Convergence {
  std::string name;             ///< "independent", "sobol, adaptive, denoised"
  std::optional<PowerLaw> mse;  ///< of samples a pixel
  double equal_time_gain = 0;   ///< independent's MSE over this one's in the same time; 0: unknown
};

/// How often intervals hold.
struct Calibration {
  std::string name;            ///< "all", "sobol"
  ByLevel pixels{};            ///< pooled over pixels, channels and runs
  std::size_t pixel_runs = 0;  ///< denoised pictures have none
  ByLevel pictures{};          ///< of the RMSE
  std::size_t runs = 0;
};

/// Where and when it was measured.
struct Occasion {
  std::string processor;  ///< its model
  std::string isa;        ///< that the scene's own settings use here
  std::string date;       ///< of the last measurement: "2026-11-22"
};

/// All that a trade has found.
struct Findings {
  std::string scene_file;
  std::size_t spheres = 0;
  Occasion occasion;
  RenderSettings scene;  ///< its own, its own size
  RenderSettings base;   ///< as measured
  Timing timing;
  std::vector<Row> rows;
  PairedBiases biases;
  std::vector<Convergence> convergence;
  std::vector<Calibration> calibration;
  std::vector<FarmFront> farms;  ///< modelled
  double reference_samples = 0;
  double reference_rmse = 0;
  std::vector<std::string> left_out;  ///< canonical forms
  std::vector<std::string> notes;     ///< sentences about what is limited
  std::string answer;
  nlohmann::json answer_facts;
};

/// Rows of the scene's own depth, precision and accelerator, by how samples are spent: the names of
/// Convergence.
using Families = std::map<std::string, std::vector<const Row*>>;
Families families_of(const std::vector<Row>& rows, const RenderSettings& base);

/// Rows of `runs`, as `variants` order them, with their budgets and the front.
std::vector<Row> rows_of(const std::vector<Variant>& variants, const std::vector<Run>& runs,
                         const PairedBiases& biases, const Timing& timing);
std::vector<Convergence> convergence_of(const std::vector<Row>& rows, const RenderSettings& base);
std::vector<Calibration> calibration_of(const std::vector<Row>& rows);

// Tables with a header. The plots read them: names have no commas.
std::string csv_of(const Findings& findings);
/// The modelled fronts.
std::string farms_csv_of(const Findings& findings);
/// How often intervals hold.
std::string intervals_csv_of(const Findings& findings);
nlohmann::json json_of(const Findings& findings);
/// For people: the front, the budget, what was found. Without the answer.
std::string text_of(const Findings& findings);

}  // namespace parray::tradeoff
