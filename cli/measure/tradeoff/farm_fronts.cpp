#include "cli/measure/tradeoff/farm_fronts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/measure/plan/farm_model.h"
#include "cli/measure/tradeoff/variant.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

constexpr std::array<std::uint32_t, 4> farm_sizes = {1, 4, 16, 64};

double seconds_of(const Row& row, const RenderSettings& scene, std::uint32_t workers, int threads) {
  RenderSettings settings = row.settings;
  settings.width = scene.width;
  settings.height = scene.height;
  const FarmModel farm(settings, std::vector<double>(workers, 1),
                       static_cast<std::uint32_t>(threads));
  const double larger = pixels_of(settings) / pixels_of(row.settings);
  const int passes = std::max(static_cast<int>(std::lround(row.passes)), 1);
  return farm.seconds(larger * (row.seconds.median - row.denoise_seconds), row.samples, passes) +
         larger * row.denoise_seconds;
}

}  // namespace

std::vector<FarmFront> farm_fronts_of(const std::vector<Row>& rows, const RenderSettings& scene,
                                      int threads) {
  std::vector<FarmFront> fronts;
  for (const std::uint32_t workers : farm_sizes) {
    FarmFront front{workers};
    std::vector<CostAndError> costs;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!(rows[i].rmse > 0)) continue;
      const double seconds = seconds_of(rows[i], scene, workers, threads);
      front.points.push_back({i, seconds, rows[i].rmse});
      costs.push_back({seconds, rows[i].rmse});
    }
    const std::vector<std::size_t> dominators = dominators_of(costs);
    for (std::size_t i = 0; i < costs.size(); ++i) front.points[i].on_front = dominators[i] == i;
    fronts.push_back(std::move(front));
  }
  return fronts;
}

}  // namespace parray::tradeoff
