#pragma once

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "common/math/float_mode.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/window_rig.h"
#include "worker/cell_tracer.h"

namespace parray::test {

inline std::shared_ptr<const Scene> shared_scene() {
  static const auto scene = std::make_shared<const Scene>(small_scene());
  return scene;
}

inline RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings = small_settings(*shared_scene());
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  return settings;
}

/// Hours of work, in cells of a fifth of a millisecond.
inline RenderSettings endless() { return sized(64, 64, 1U << 17); }

inline CellBatch whole(const RenderSettings& settings, std::uint32_t tile = 0) {
  const auto plan = whole_plan(settings, tile);
  return plan->batch({0, plan->cells()});
}

/// Traces cells without a team and checks the number of samples.
inline TracedCells traced(const PathTracer& tracer, const CellBatch& batch, int threads) {
  std::atomic<std::uint64_t> count = 0;
  TracedCells cells = trace_cells(tracer, batch, threads, count, false);
  CHECK(count == batch.sample_count());
  return cells;
}

inline std::vector<std::byte> without_times(const TracedCells& cells) {
  std::vector<std::byte> records = cells.records;
  const std::size_t size = records.size() / cells.range.count();
  for (std::size_t at = 0; at < records.size(); at += size) {
    std::memset(records.data() + at + offsetof(CellHeader, nanoseconds), 0, sizeof(std::uint64_t));
  }
  return records;
}

/// Returns the expected records: one thread traces each sample by a call of its own.
inline std::vector<std::byte> plain_records(const RenderSettings& settings,
                                            const CellBatch& batch) {
  const FloatMode ieee;
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  std::vector<std::byte> records;
  for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
    const Cell cell = batch.grid->cell(index);
    const auto ranges = batch.run_samples(index);
    std::vector<PixelSums> sums(batch.grid->shape().cell_pixels);
    TraceCounts counts;
    for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
      for (std::uint32_t s = ranges[i].begin; s < ranges[i].end; ++s) {
        const std::uint32_t x = cell.x_begin + i;
        tracer->trace({cell.y, x, x + 1}, {s, s + 1}, {&sums[i], 1}, counts);
      }
    }
    const CellHeader header{counts.rays, counts.nonfinite, counts.lost, 0};
    const auto* const head = reinterpret_cast<const std::byte*>(&header);
    const auto pixels = std::as_bytes(std::span(sums));
    records.insert(records.end(), head, head + sizeof header);
    records.insert(records.end(), pixels.begin(), pixels.end());
  }
  return records;
}

/// Waits until `condition` is true. Returns false after a minute.
template <typename Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 60'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// A tracer that throws at one pixel, in the thread that traces it.
class ThrowingTracer final : public PathTracer {
 public:
  explicit ThrowingTracer(std::function<void()> fail)
      : PathTracer(make_path_tracer(*shared_scene(), sized(6, 5, 4))->accelerator()),
        fail_(std::move(fail)) {}
  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    if (run.y == 5 && run.x_begin <= 3 && 3 < run.x_end) fail_();
    for (std::size_t i = 0; i < sums.size(); ++i) counts.samples += samples[i].count();
  }
  void first_hits(const PixelRun& /*run*/, const SampleRange& /*samples*/,
                  std::span<FirstHit> /*hits*/) const override {}
  void add_sky_samples(const PixelRun& /*run*/, const RunSamples& /*samples*/,
                       std::span<SkySamples> /*sky*/) const override {}

 private:
  std::function<void()> fail_;
};

}  // namespace parray::test
