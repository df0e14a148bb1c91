#include "common/schedule/chunk_policy.h"

#include <algorithm>
#include <cmath>

#include "common/base/divide_up.h"

namespace parray::schedule {
namespace {

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

}  // namespace parray::schedule
