#include "coordinator/jobs/work_map.h"

#include <map>
#include <utility>

#include "common/base/bytes.h"
#include "common/schedule/cell_grid.h"

namespace parray::coordinator {

WorkMap work_map(const std::vector<JournalEntry>& journal, std::uint32_t width,
                 std::uint32_t height) {
  WorkMap map{width, height, {}, {}, {}};
  map.seconds.resize(std::size_t{width} * height);
  map.tracer.resize(map.seconds.size(), WorkMap::no_worker);
  std::map<TracerKey, std::pair<std::uint32_t, std::uint32_t>> workers;  // number, threads
  std::map<std::uint32_t, CellGrid> grids;                               // by pass
  const auto take = [&](const JournalMerge& e) {
    const auto grid = grids.find(e.pass);
    const auto worker = workers.find(e.tracer);
    if (grid == grids.end()) return;
    if (worker == workers.end() || e.range.end > grid->second.cells()) {
      throw DecodeError("a lease of an unknown worker, or with cells that its pass lacks");
    }
    const std::vector<Cell> cells = grid->second.cells_of(e.range);
    double samples = 0;
    for (const Cell& cell : cells) {
      samples += static_cast<double>(cell.pixels()) * cell.samples.count();
    }
    const auto [number, threads] = worker->second;
    const double each = samples > 0 ? e.seconds * threads / samples : 0;
    for (const Cell& cell : cells) {
      const std::size_t row = std::size_t{cell.y} * width;
      for (std::uint32_t x = cell.x_begin; x < cell.x_end; x += cell.step) {
        map.seconds[row + x] += static_cast<float>(each * cell.samples.count());
        map.tracer[row + x] = number;
      }
    }
  };
  // The time of retracted cells counts, too. A later merge names the worker that traced them again.
  for (const JournalEntry& entry : journal) {
    if (const auto* worker = std::get_if<JournalWorker>(&entry)) {
      workers[worker->tracer] = {static_cast<std::uint32_t>(map.workers.size()), worker->threads};
      map.workers.push_back(worker->name);
    } else if (const auto* grid = std::get_if<JournalGrid>(&entry)) {
      if (grid->shape.width != width || grid->shape.height != height) {
        throw DecodeError("a pass of another picture");
      }
      grids.insert_or_assign(grid->pass, CellGrid(grid->shape));
    } else if (const auto* merge = std::get_if<JournalMerge>(&entry)) {
      take(*merge);
    }
  }
  return map;
}

}  // namespace parray::coordinator
