#include "common/schedule/chunk_sizer.h"

#include <algorithm>

namespace parray::schedule {

/// Samples per thread of a lease to a worker that has not been measured yet: about 10 ms on a core
/// of 10 M samples/s.
static constexpr double first_lease_samples = 1e5;

/// Converts a number of cells, which may exceed every possible number of cells.
static std::uint64_t cells_of(double number) {
  return static_cast<std::uint64_t>(std::min(number, 0x1p62));
}

ChunkGrain grain_of(const WorkPlan& plan) {
  return {plan.cells(), plan.grid()->cells_per_row(), plan.grid()->shape().piece_cells,
          plan.cell_samples()};
}

ChunkSizer::ChunkSizer(SchedulePolicy policy, const WorkPlan& plan, LeaseLength length,
                       std::optional<std::uint64_t> cells)
    : ChunkSizer(policy, grain_of(plan), length) {
  grain_.cells = cells.value_or(grain_.cells);
}

ChunkSizer::ChunkSizer(SchedulePolicy policy, const ChunkGrain& grain, LeaseLength length)
    : policy_(policy), length_(length), grain_(grain) {}

std::uint64_t ChunkSizer::cells(const LeaseRequest& request, const FarmSpeed& farm,
                                std::uint64_t remaining, std::uint64_t step) const {
  // A worker without a measurement counts as fast per thread as the measured workers.
  const double per_thread =
      farm.measured_threads > 0
          ? farm.samples_per_second / static_cast<double>(farm.measured_threads)
          : 1;
  const double measured = request.samples_per_second;
  const double speed = measured > 0 ? measured : per_thread * request.threads;
  const double others =
      static_cast<double>(farm.threads - std::min(farm.threads, farm.measured_threads));
  const double all = std::max(farm.samples_per_second + per_thread * others, speed);
  const double most =
      measured > 0 ? speed * length_.longest : first_lease_samples * request.threads;
  const double least = measured * length_.shortest;
  ChunkRequest chunk;
  chunk.total = std::max(grain_.cells, remaining);
  chunk.remaining = remaining;
  chunk.step = step;
  chunk.row_units = grain_.row_cells;
  chunk.workers = std::max(farm.workers, 1U);
  chunk.threads = request.threads;
  const double share = speed / all;  // NaN if both are infinite
  chunk.share = share > 1e-9 ? std::min(share, 1.0) : 1e-9;
  chunk.least = std::max<std::uint64_t>(cells_of(least / grain_.cell_samples),
                                        std::uint64_t{request.threads} * grain_.piece_cells);
  chunk.most = std::max(cells_of(most / grain_.cell_samples), chunk.least);
  return chunk_units(policy_, chunk);
}

std::vector<std::uint64_t> ChunkSizer::starts(std::uint32_t workers,
                                              std::uint32_t threads_each) const {
  ChunkRequest job;
  job.total = grain_.cells;
  job.row_units = grain_.row_cells;
  job.workers = workers;
  job.threads = threads_each;
  return chunk_starts(policy_, job);
}

}  // namespace parray::schedule
