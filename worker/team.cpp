#include "worker/team.h"

#include <omp.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "common/math/float_mode.h"
#include "common/schedule/row_order.h"
#include "common/trace/nonfinite.h"
#include "proto/clock.h"

namespace parray {
namespace {

/// About a millisecond of work: small enough that threads end together, large enough that dealing
/// it out costs nothing.
constexpr std::uint64_t piece_samples = 2048;

/// How a rectangle is cut into pieces: runs of pixels, and within them ranges of samples.
struct Pieces {
  Pieces(std::uint32_t width, const WorkRect& rect)
      : samples_each(
            static_cast<std::uint32_t>(std::min<std::uint64_t>(rect.samples(), piece_samples))),
        pixels_each(static_cast<std::uint32_t>(
            std::clamp<std::uint64_t>(piece_samples / rect.samples(), 1, width))),
        sample_parts((rect.samples() + samples_each - 1) / samples_each),
        row_parts((width + pixels_each - 1) / pixels_each) {}

  std::uint32_t samples_each;
  std::uint32_t pixels_each;
  std::uint64_t sample_parts;
  std::uint64_t row_parts;
};

}  // namespace

RowBlock trace_rect(const Kernel& kernel, const RenderSettings& settings, const WorkRect& rect,
                    int threads, std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop,
                    std::span<const SampleRange> samples) {
  const std::vector<std::uint32_t> row_at = make_row_order(settings.row_order, settings.height);
  const std::uint32_t width = settings.width;
  RowBlock block{rect, width, {}, std::vector<PixelSums>(std::size_t{rect.rows()} * width)};
  const Pieces pieces(width, rect);
  const auto count =
      static_cast<std::int64_t>(rect.rows() * pieces.row_parts * pieces.sample_parts);
  std::mutex merging;
#pragma omp parallel num_threads(threads)
  {
    const FloatMode ieee;
    TraceCounts counts;
    std::vector<PixelSums> sums;
    std::vector<SampleRange> ranges;
#pragma omp for schedule(dynamic) nowait
    for (std::int64_t i = 0; i < count; ++i) {
      if (stop.load(std::memory_order_relaxed)) {
        continue;
      }
      const auto piece = static_cast<std::uint64_t>(i);
      const auto part = static_cast<std::uint32_t>(piece % pieces.sample_parts);
      const std::uint64_t run_index = piece / pieces.sample_parts;
      const auto row = static_cast<std::uint32_t>(run_index / pieces.row_parts);
      const auto begin =
          static_cast<std::uint32_t>(run_index % pieces.row_parts) * pieces.pixels_each;
      const PixelRun run{row_at[rect.row_begin + row], begin,
                         std::min(begin + pieces.pixels_each, width)};
      const std::uint32_t first = rect.sample_begin + part * pieces.samples_each;
      const SampleRange part_samples{first, std::min(first + pieces.samples_each, rect.sample_end)};
      const std::size_t pixel = std::size_t{row} * width + begin;
      ranges.assign(run.x_end - begin, part_samples);
      for (std::size_t x = 0; !samples.empty() && x < ranges.size(); ++x) {
        ranges[x] = common_of(samples[pixel + x], part_samples);
      }
      const std::uint64_t nonfinite_before = counts.nonfinite;
      const std::span<PixelSums> target(block.pixels.data() + pixel, run.x_end - begin);
      const std::uint64_t samples_before = counts.samples;
      if (pieces.sample_parts == 1) {
        kernel.trace_run(run, RunSamples(ranges), target,
                         counts);  // the pixels are this piece's alone
      } else {
        sums.assign(target.size(), {});
        kernel.trace_run(run, RunSamples(ranges), sums, counts);
        const std::scoped_lock lock(merging);
        for (std::size_t x = 0; x < sums.size(); ++x) {
          target[x] += sums[x];
        }
      }
      if (counts.nonfinite != nonfinite_before) {
        const auto found = locate_nonfinite(kernel, run, ranges, rect.row_begin + row);
        const std::scoped_lock lock(merging);
        block.excluded.insert(block.excluded.end(), found.begin(), found.end());
      }
      traced.fetch_add(counts.samples - samples_before, std::memory_order_relaxed);
    }
    const std::scoped_lock lock(merging);
    block.counts += counts;
  }
  // Threads find them in any order; equal leases have equal bytes.
  std::sort(block.excluded.begin(), block.excluded.end());
  return block;
}

ThreadTeam::ThreadTeam(int threads, std::function<void()> on_finished)
    : threads_(threads),
      thread_([this](const Assignment& assignment,
                     const std::atomic<bool>& stop) { return trace(assignment, stop); },
              std::move(on_finished)) {}

Finished ThreadTeam::trace(const Assignment& assignment, const std::atomic<bool>& stop) {
  const SteadyClock clock;
  if (!kernel_ || kernel_scene_ != assignment.scene_id ||
      !(kernel_settings_ == assignment.settings)) {
    const Time begin = clock.now();
    preparing_ = true;
    kernel_.reset();  // before the next one is built: two may not fit
    KernelOptions options;
    options.build_threads = threads_;
    kernel_ = make_kernel(*assignment.scene, assignment.settings, options);
    kernel_scene_ = assignment.scene_id;
    kernel_settings_ = assignment.settings;
    build_seconds_ = to_seconds(clock.now() - begin);
    preparing_ = false;
  }
  const Time begin = clock.now();
  Finished finished;
  finished.job = assignment.job;
  finished.epoch = assignment.epoch;
  finished.block = trace_rect(*kernel_, assignment.settings, assignment.rect, threads_, traced_,
                              stop, assignment.samples);
  finished.seconds = to_seconds(clock.now() - begin);
  finished.build_seconds = build_seconds_;
  finished.accelerator_bytes = kernel_->accelerator_bytes();
  finished.isa = kernel_->isa();
  return finished;
}

}  // namespace parray
