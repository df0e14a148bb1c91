#pragma once

#include <cstdint>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"

/// Pareto fronts of farms. Modelled, not measured.
namespace parray::tradeoff {

/// The predicted picture with the settings of a row, in the size that the scene states.
struct FarmPoint {
  std::size_t row = 0;  ///< index of the row
  double seconds = 0;   ///< predicted wall-clock time
  double rmse = 0;      ///< Row::rmse
  bool on_front = false;
};

struct FarmFront {
  std::uint32_t workers = 0;        ///< workers as fast as this machine
  std::vector<FarmPoint> points{};  ///< rows with a known error
};

/// Returns the fronts for 1, 4, 16 and 64 workers of `threads` threads. Scales the time of each row
/// to the number of pixels of `scene` and replays the coordinator's lease rules in virtual time
/// (cli/measure/plan/farm_model.h), in the row's number of passes. Leaves out the network. One
/// machine denoises.
std::vector<FarmFront> farm_fronts_of(const std::vector<Row>& rows, const RenderSettings& scene,
                                      int threads);

}  // namespace parray::tradeoff
