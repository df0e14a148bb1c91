#include "worker/cell_team.h"

#include <omp.h>

#include <cstring>
#include <utility>

#include "common/math/float_mode.h"
#include "common/schedule/row_order.h"
#include "proto/clock.h"
#include "proto/window.h"

namespace parray {

ThreadCellTeam::ThreadCellTeam(Scene scene, const RenderSettings& settings, Plan plan, int threads)
    : scene_(std::make_unique<const Scene>(std::move(scene))),
      settings_(settings),
      plan_(std::move(plan)),
      threads_(threads),
      row_at_(make_row_order(settings.row_order, settings.height)),
      thread_([this](const Task& task, const std::atomic<bool>& stop) { return trace(task, stop); },
              [] {}) {}

ThreadCellTeam::Built ThreadCellTeam::built() const {
  const std::scoped_lock lock(mutex_);
  return built_;
}

TracedCells ThreadCellTeam::trace(const Task& task, const std::atomic<bool>& stop) {
  if (!kernel_) {
    building_ = true;
    build();
    building_ = false;
  }
  const SteadyClock clock;
  const Time begin = clock.now();
  const std::uint64_t before = traced_;
  TracedCells traced = trace_cells(task, stop);
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

TracedCells ThreadCellTeam::trace_cells(const Task& task, const std::atomic<bool>& stop) {
  const SteadyClock clock;
  const WorkPlan& plan = *task.plan;
  const CellRange& range = task.range;
  const auto piece = static_cast<int>(plan.piece_cells());
  const std::size_t record_bytes = record_bytes_of(plan);
  TracedCells result{range, std::vector<std::byte>(range.count() * record_bytes), 0, 0};
#pragma omp parallel num_threads(threads_)
  {
    const FloatMode ieee;
    std::vector<PixelSums> sums;
    std::vector<SampleRange> samples;
    Time before = clock.now();
#pragma omp for schedule(dynamic, piece) nowait
    for (std::uint64_t index = range.begin; index < range.end; ++index) {
      if (stop.load(std::memory_order_relaxed)) {
        continue;
      }
      const Cell cell = plan.cell(index);
      if (cell.samples() == 0) {
        continue;  // its record is zeros
      }
      TraceCounts counts;
      sums.assign(cell.pixels(), {});
      samples = cell.sample_ranges();
      kernel_->trace_run({row_at_[cell.position], cell.x_begin, cell.x_end}, RunSamples(samples),
                         sums, counts);
      const Time after = clock.now();
      const CellHeader header{counts.rays, counts.nonfinite, counts.lost,
                              static_cast<std::uint64_t>((after - before).count())};
      before = after;
      std::byte* const record = result.records.data() + (index - range.begin) * record_bytes;
      std::memcpy(record, &header, sizeof header);
      std::memcpy(record + sizeof header, sums.data(), sums.size() * sizeof(PixelSums));
      traced_.fetch_add(counts.samples, std::memory_order_relaxed);
    }
  }
  return result;
}

}  // namespace parray
