#include "worker/cell_tracer.h"

#include <omp.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <mutex>
#include <vector>

#include "common/math/float_mode.h"
#include "common/trace/tracer.h"
#include "proto/clock.h"

namespace parray::worker {
namespace {

/// Collects the results of the threads that trace some cells.
class CellTracer {
 public:
  CellTracer(const PathTracer& tracer, const CellBatch& batch)
      : tracer_(tracer),
        batch_(batch),
        record_bytes_(record_bytes(batch.grid->shape().cell_pixels)) {
    result_.range = batch.range;
    result_.records.resize(batch.range.count() * record_bytes_);
  }

  /// Traces a cell and returns its number of samples. `since` is the time when the thread began the
  /// cell; the function sets it to the time when the cell ended. Thread-safe.
  std::uint64_t trace(std::uint64_t index, Time& since) {
    const std::vector<SampleRange> ranges = batch_.column_ranges_of(index);
    if (std::ranges::all_of(ranges, [](const SampleRange& range) { return range.count() == 0; })) {
      return 0;  // its record is zeros
    }
    const Cell cell = batch_.grid->cell(index);
    const PixelRun run{cell.y, cell.x_begin, cell.x_end};
    std::vector<PixelSums> sums(ranges.size());
    TraceCounts counts;
    tracer_.trace_run(run, RunSamples(ranges), sums, counts);
    for (std::size_t i = 1; cell.step > 1 && i < cell.pixels(); ++i) sums[i] = sums[i * cell.step];
    sums.resize(cell.pixels());
    if (counts.nonfinite > 0) {
      const auto found = locate_nonfinite(tracer_, run, ranges);
      const std::scoped_lock lock(mutex_);
      for (const ExcludedSamples& some : found) excluded_.emplace_back(index, some);
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

  /// Returns the result of the cells before `end`. `samples` is the number of all traced samples.
  TracedCells take(std::uint64_t end, std::uint64_t samples, Time began) {
    result_.samples = samples;
    if (end < batch_.range.end) cut(end);
    for (const auto& [index, some] : excluded_) {
      if (index < end) result_.excluded.push_back(some);
    }
    // Threads find excluded samples in any order. Sorting makes the bytes of equal leases equal.
    std::ranges::sort(result_.excluded);
    result_.seconds = to_seconds(clock_.now() - began);
    return std::move(result_);
  }

 private:
  void cut(std::uint64_t end) {
    CellBatch traced{batch_.grid, {batch_.range.begin, end}, batch_.samples};
    if (!traced.samples.empty()) {
      traced.samples.resize(traced.range.count() * batch_.grid->shape().cell_pixels);
    }
    result_.range = traced.range;
    result_.records.resize(traced.range.count() * record_bytes_);
    result_.samples = traced.sample_count();
  }

  const PathTracer& tracer_;
  const CellBatch& batch_;
  const std::size_t record_bytes_;
  const SteadyClock clock_;
  std::mutex mutex_;  // guards excluded_; only one thread writes a record
  std::vector<std::pair<std::uint64_t, ExcludedSamples>> excluded_;  // with the cells' indices
  TracedCells result_;
};

}  // namespace

TracedCells trace_cells(const PathTracer& tracer, const CellBatch& batch, int threads,
                        std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop,
                        double longest) {
  CellTracer cells(tracer, batch);
  const Time began = cells.now();
  const std::uint64_t piece = batch.grid->shape().piece_cells;
  const std::uint64_t pieces = (batch.range.count() + piece - 1) / piece;
  std::uint64_t end = batch.range.end;
  std::uint64_t samples = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
#pragma omp parallel num_threads(threads) reduction(min : end) reduction(+ : samples)
  {
    const FloatMode ieee;
    Time since = cells.now();
#pragma omp for schedule(monotonic : dynamic) nowait
    for (std::uint64_t number = 0; number < pieces; ++number) {
      const std::uint64_t first = batch.range.begin + number * piece;
      if (longest > 0 && number > 0 && to_seconds(since - began) >= longest) {
        end = std::min(end, first);  // every earlier piece is traced, or lowers `end` itself
      }
      const std::uint64_t last = std::min({first + piece, batch.range.end, end});
      for (std::uint64_t index = first; index < last; ++index) {
        if (stop.load(std::memory_order_relaxed) || failed.load(std::memory_order_relaxed)) break;
        try {
          const std::uint64_t count = cells.trace(index, since);
          samples += count;
          traced.fetch_add(count, std::memory_order_relaxed);
        } catch (...) {  // no exception may leave an OpenMP region
          if (!failed.exchange(true)) failure = std::current_exception();
        }
      }
    }
  }
  if (failure) std::rethrow_exception(failure);
  return cells.take(end, samples, began);
}

}  // namespace parray::worker
