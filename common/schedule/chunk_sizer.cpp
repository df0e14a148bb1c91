#include "common/schedule/chunk_sizer.h"

#include <algorithm>
#include <cmath>

#include "common/base/divide_up.h"

namespace parray::schedule {
namespace {

/// Samples per thread of a lease to a worker that has not been measured yet: about 10 ms on a core
/// of 10 M samples/s.
constexpr double first_lease_samples = 1e5;

/// Converts a number of cells, which may exceed every possible number of cells.
std::uint64_t cells_of(double number) {
  return static_cast<std::uint64_t>(std::min(number, 0x1p62));
}

std::uint64_t static_rows(const ChunkRequest& r) {
  return divide_up(divide_up(r.total, r.row_units), r.workers);
}

std::uint64_t guided_rows(const ChunkRequest& r) {
  const std::uint64_t fair = divide_up(divide_up(r.remaining, r.row_units), r.workers);
  return std::max<std::uint64_t>(fair, 2ULL * r.threads);
}

std::uint64_t factoring_rows(const ChunkRequest& r) {
  const std::uint64_t batch = std::min<std::uint64_t>(r.step / r.workers, 62);
  const std::uint64_t batch_rows = divide_up(r.total, r.row_units) >> batch;
  return std::max<std::uint64_t>(divide_up(batch_rows, 2ULL * r.workers), 1);
}

std::uint64_t weighted_units(const ChunkRequest& r) {
  const double half_share = static_cast<double>(r.remaining) * r.share / 2;
  return std::clamp(static_cast<std::uint64_t>(std::ceil(half_share)), r.least,
                    std::max(r.least, r.most));
}

}  // namespace

std::uint64_t chunk_units(SchedulePolicy policy, const ChunkRequest& request) {
  std::uint64_t units = 0;
  switch (policy) {
    case SchedulePolicy::static_split: units = static_rows(request) * request.row_units; break;
    case SchedulePolicy::guided: units = guided_rows(request) * request.row_units; break;
    case SchedulePolicy::factoring: units = factoring_rows(request) * request.row_units; break;
    case SchedulePolicy::weighted: units = weighted_units(request); break;
  }
  return std::clamp<std::uint64_t>(units, 1, request.remaining);
}

std::vector<std::uint64_t> chunk_starts(SchedulePolicy policy, ChunkRequest job) {
  std::vector<std::uint64_t> starts = {0};
  for (job.remaining = job.total, job.step = 0; job.remaining > 0; ++job.step) {
    const std::uint64_t units = chunk_units(policy, job);
    job.remaining -= units;
    starts.push_back(starts.back() + units);
  }
  return starts;
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
