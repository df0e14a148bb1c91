#include "tests/experiments/simulation/seed_job.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>

#include "common/scene/settings.h"
#include "common/schedule/chunk_sizer.h"
#include "tests/support/rooms.h"

namespace parray::simulation {
namespace {

/// Until the last thread is done with rows that are given to whoever is free.
double length_of(const JobOptions& job, std::uint64_t begin, std::uint64_t end) {
  std::vector<double> threads(job.threads);
  for (std::uint64_t row = begin; row < end; ++row) {
    *std::min_element(threads.begin(), threads.end()) += job.row_seconds[row];
  }
  return *std::max_element(threads.begin(), threads.end());
}

}  // namespace

SeedJob seed_job(const JobOptions& job, SchedulePolicy policy) {
  ChunkRequest request;
  request.total = job.settings.height;
  request.workers = job.ranks;
  request.threads = job.threads;
  const std::vector<std::uint64_t> starts = chunk_starts(policy, request);
  const double row_bytes = job.settings.width * 3.0 * sizeof(float);
  using Free = std::pair<double, std::uint32_t>;  // when, which rank
  std::priority_queue<Free, std::vector<Free>, std::greater<>> free_at;
  for (std::uint32_t rank = 0; rank < job.ranks; ++rank) free_at.emplace(0, rank);
  SeedJob result;
  result.work = std::accumulate(job.row_seconds.begin(), job.row_seconds.end(), 0.0);
  result.leases = starts.size() - 1;
  result.normalized.resize(job.ranks);
  for (std::size_t lease = 0; lease < result.leases; ++lease) {
    const auto [begin, rank] = free_at.top();
    free_at.pop();
    const double speed = job.speeds.empty() ? 1 : job.speeds[rank];
    const double tracing = length_of(job, starts[lease], starts[lease + 1]) / speed;
    const double bytes = row_bytes * static_cast<double>(starts[lease + 1] - starts[lease]);
    const double ask = policy == SchedulePolicy::static_split ? 0 : 2 * job.link.atomic;
    const double end = begin + ask + tracing + job.link.put + bytes / job.link.bytes_per_second;
    result.normalized[rank] += tracing;
    result.seconds = std::max(result.seconds, end);
    free_at.emplace(end, rank);
  }
  for (double& seconds : result.normalized) seconds /= result.seconds;
  return result;
}

}  // namespace parray::simulation
