#pragma once

#include <cstdint>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"

/// The front as farms would have it. Modelled, not measured.
namespace parray::tradeoff {

/// A row's picture in the scene's own size.
struct FarmPoint {
  std::size_t row = 0;  ///< its number
  double seconds = 0;
  double rmse = 0;  ///< as measured
  bool on_front = false;
};

struct FarmFront {
  std::uint32_t workers = 0;        ///< each as fast as this machine
  std::vector<FarmPoint> points{};  ///< of rows that have an error
};

/// For 1, 4, 16 and 64 workers of `threads` threads: the time that a row took, in proportion to the
/// pixels of the `scene`'s own settings, dealt out by the coordinator's own rules in virtual time
/// (cli/measure/plan/farm_model.h), in as many passes as it had. Nothing is sent. A single machine
/// denoises.
std::vector<FarmFront> farm_fronts_of(const std::vector<Row>& rows, const RenderSettings& scene,
                                      int threads);

}  // namespace parray::tradeoff
