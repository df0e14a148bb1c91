#include "coordinator/jobs/work_map.h"

#include <map>
#include <utility>

#include "common/base/bytes.h"
#include "common/schedule/cell_grid.h"

namespace parray::coordinator {
namespace {

class Mapper {
 public:
  Mapper(std::uint32_t width, std::uint32_t height) {
    map_.width = width;
    map_.height = height;
    map_.seconds.resize(std::size_t{width} * height);
    map_.tracer.resize(map_.seconds.size(), WorkMap::no_worker);
  }

  void take(const JournalWorker& e) {
    workers_[e.tracer] = {static_cast<std::uint32_t>(map_.workers.size()), e.threads};
    map_.workers.push_back(e.name);
  }
  void take(const JournalPass& /*entry*/) {}
  void take(const JournalGrid& e) {
    if (e.shape.width != map_.width || e.shape.height != map_.height) {
      throw DecodeError("a pass of another picture");
    }
    grids_.insert_or_assign(e.pass, CellGrid(e.shape));
  }
  void take(const JournalMerge& e) {
    const auto grid = grids_.find(e.pass);
    const auto worker = workers_.find(e.tracer);
    if (grid == grids_.end()) return;
    if (worker == workers_.end() || e.range.end > grid->second.cells()) {
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
      const std::size_t row = std::size_t{cell.y} * map_.width;
      for (std::uint32_t x = cell.x_begin; x < cell.x_end; x += cell.step) {
        map_.seconds[row + x] += static_cast<float>(each * cell.samples.count());
        map_.tracer[row + x] = number;
      }
    }
  }
  /// The time counts nevertheless. A later merge names the worker that traced the cells again.
  void take(const JournalRetraction& /*entry*/) {}

  WorkMap result() { return std::move(map_); }

 private:
  WorkMap map_;
  std::map<TracerKey, std::pair<std::uint32_t, std::uint32_t>> workers_;  ///< number, threads
  std::map<std::uint32_t, CellGrid> grids_;
};

}  // namespace

WorkMap work_map(const std::vector<JournalEntry>& journal, std::uint32_t width,
                 std::uint32_t height) {
  Mapper mapper(width, height);
  for (const JournalEntry& entry : journal) {
    std::visit([&mapper](const auto& e) { mapper.take(e); }, entry);
  }
  return mapper.result();
}

}  // namespace parray::coordinator
