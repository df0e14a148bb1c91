#include "worker/cell_team.h"

#include <omp.h>

#include <cstring>
#include <utility>

#include "common/math/float_mode.h"
#include "common/schedule/row_order.h"
#include "proto/clock.h"
#include "proto/window.h"

namespace parray {

ThreadCellTeam::ThreadCellTeam(Scene scene, const RenderSettings& settings, const WorkPlan& plan,
                               int threads)
    : scene_(std::make_unique<const Scene>(std::move(scene))),
      settings_(settings),
      plan_(plan),
      threads_(threads),
      piece_(static_cast<int>(plan.piece_cells())),
      row_at_(make_row_order(settings.row_order, settings.height)),
      thread_([this](const CellRange& range,
                     const std::atomic<bool>& stop) { return trace(range, stop); },
              [] {}) {}

ThreadCellTeam::Built ThreadCellTeam::built() const {
  const std::scoped_lock lock(mutex_);
  return built_;
}

TracedCells ThreadCellTeam::trace(const CellRange& range, const std::atomic<bool>& stop) {
  if (!kernel_) {
    building_ = true;
    build();
    building_ = false;
  }
  const SteadyClock clock;
  const Time begin = clock.now();
  const std::uint64_t before = traced_;
  TracedCells traced = trace_cells(range, stop);
  traced.samples = traced_ - before;
  traced.seconds = to_seconds(clock.now() - begin);
  return traced;
}

void ThreadCellTeam::build() {
  const SteadyClock clock;
  const Time begin = clock.now();
  KernelOptions options;
  options.build_threads = threads_;
  kernel_ = make_kernel(*scene_, settings_, options);
  scene_.reset();  // the kernel has what it needs
  const std::scoped_lock lock(mutex_);
  built_ = {to_seconds(clock.now() - begin), kernel_->accelerator_bytes(),
            std::string(kernel_->isa())};
}

TracedCells ThreadCellTeam::trace_cells(const CellRange& range, const std::atomic<bool>& stop) {
  const SteadyClock clock;
  const std::size_t record_bytes = record_bytes_of(plan_);
  TracedCells result{range, std::vector<std::byte>(range.count() * record_bytes), 0, 0};
#pragma omp parallel num_threads(threads_)
  {
    const FloatMode ieee;
    std::vector<PixelSums> sums;
    Time before = clock.now();
#pragma omp for schedule(dynamic, piece_) nowait
    for (std::uint64_t index = range.begin; index < range.end; ++index) {
      if (stop.load(std::memory_order_relaxed)) {
        continue;
      }
      const Cell cell = plan_.cell(index);
      TraceCounts counts;
      sums.assign(cell.pixels(), {});
      kernel_->trace({row_at_[cell.position], cell.x_begin, cell.x_end},
                     {cell.sample_begin, cell.sample_end}, sums, counts);
      const Time after = clock.now();
      const CellHeader header{counts.rays, counts.nonfinite, counts.lost,
                              static_cast<std::uint64_t>((after - before).count())};
      before = after;
      std::byte* const record = result.records.data() + (index - range.begin) * record_bytes;
      std::memcpy(record, &header, sizeof header);
      std::memcpy(record + sizeof header, sums.data(), sums.size() * sizeof(PixelSums));
      traced_.fetch_add(cell.samples(), std::memory_order_relaxed);
    }
  }
  return result;
}

}  // namespace parray
