#include "worker/cell_tracer.h"

#include <omp.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <mutex>
#include <vector>

#include "common/math/float_mode.h"
#include "common/trace/integrator/nonfinite.h"
#include "proto/clock.h"

namespace parray {
namespace {

/// What a team of threads makes of some cells.
class CellTracer {
 public:
  CellTracer(const PathTracer& tracer, const CellBatch& batch)
      : tracer_(tracer),
        batch_(batch),
        record_bytes_(record_bytes(batch.grid->shape().cell_pixels)) {
    result_.range = batch.range;
    result_.records.resize(batch.range.count() * record_bytes_);
  }

  /// Any thread; `since` is when the thread began with it, and then when it ended. Returns how many
  /// samples the cell has.
  std::uint64_t trace(std::uint64_t index, Time& since) {
    const std::vector<SampleRange> ranges = batch_.column_ranges_of(index);
    if (std::all_of(ranges.begin(), ranges.end(),
                    [](const SampleRange& range) { return range.count() == 0; })) {
      return 0;  // its record is zeros
    }
    const Cell cell = batch_.grid->cell(index);
    const PixelRun run{cell.y, cell.x_begin, cell.x_end};
    std::vector<PixelSums> sums(ranges.size());
    TraceCounts counts;
    tracer_.trace_run(run, RunSamples(ranges), sums, counts);
    for (std::size_t i = 1; cell.step > 1 && i < cell.pixels(); ++i) {
      sums[i] = sums[i * cell.step];
    }
    sums.resize(cell.pixels());
    if (counts.nonfinite > 0) {
      const auto found = locate_nonfinite(tracer_, run, ranges);
      const std::scoped_lock lock(mutex_);
      result_.excluded.insert(result_.excluded.end(), found.begin(), found.end());
    }
    const Time now = clock_.now();
    const CellHeader header{counts.rays, counts.nonfinite, counts.lost,
                            static_cast<std::uint64_t>((now - since).count())};
    since = now;
    std::byte* const record = result_.records.data() + (index - batch_.range.begin) * record_bytes_;
    std::memcpy(record, &header, sizeof header);
    std::memcpy(record + sizeof header, sums.data(), sums.size() * sizeof(PixelSums));
    return counts.samples;
  }

  [[nodiscard]] Time now() const { return clock_.now(); }

  TracedCells take(std::uint64_t samples, Time began) {
    // Threads find them in any order; equal leases have equal bytes.
    std::sort(result_.excluded.begin(), result_.excluded.end());
    result_.samples = samples;
    result_.seconds = to_seconds(clock_.now() - began);
    return std::move(result_);
  }

 private:
  const PathTracer& tracer_;
  const CellBatch& batch_;
  const std::size_t record_bytes_;
  const SteadyClock clock_;
  std::mutex mutex_;  // guards result_.excluded; each record is one thread's alone
  TracedCells result_;
};

}  // namespace

TracedCells trace_cells(const PathTracer& tracer, const CellBatch& batch, int threads,
                        std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop) {
  CellTracer cells(tracer, batch);
  const Time began = cells.now();
  // NOLINTNEXTLINE(clang-analyzer-deadcode.DeadStores): the loop's schedule reads it
  const auto piece = static_cast<int>(batch.grid->shape().piece_cells);
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  std::uint64_t samples = 0;
#pragma omp parallel num_threads(threads) reduction(+ : samples)
  {
    const FloatMode ieee;
    Time since = cells.now();
#pragma omp for schedule(dynamic, piece) nowait
    for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
      if (stop.load(std::memory_order_relaxed) || failed.load(std::memory_order_relaxed)) {
        continue;
      }
      try {
        const std::uint64_t count = cells.trace(index, since);
        samples += count;
        traced.fetch_add(count, std::memory_order_relaxed);
      } catch (...) {  // none may leave a team of threads
        if (!failed.exchange(true)) {
          failure = std::current_exception();
        }
      }
    }
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
  return cells.take(samples, began);
}

}  // namespace parray
