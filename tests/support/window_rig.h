#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/leases/window_collector.h"
#include "proto/window.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "worker/window_source.h"

/// A job over a window without a tracer. Its samples are made-up numbers that depend only on row,
/// column and sample. So a test can compute the expected sums without a plan.
namespace parray::test {

inline RenderSettings made_settings(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.row_order = RowOrder::interleaved;
  return settings;
}

/// Returns the settings of a made-up job that has one pass.
inline RenderSettings made_in_one_pass() { return made_settings(40, 12, 50); }

/// Returns the settings of a made-up job that has several passes.
inline RenderSettings made_in_passes() {
  RenderSettings settings = made_settings(20, 12, 300);
  settings.adaptive = true;
  return settings;
}

inline std::shared_ptr<const WorkPlan> whole_plan(const RenderSettings& settings,
                                                  std::uint32_t tile = 0) {
  return std::make_shared<const WorkPlan>(settings, Pass{{{0, settings.samples_per_pixel}}, {}},
                                          tile);
}

/// Scrambles a number (the finalizer of SplitMix64).
inline std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  return x ^ (x >> 31);
}

/// The made-up samples of some pixels. One sample in 1024 is not finite.
struct Made {
  TraceCounts counts;
  std::vector<ExcludedSamples> excluded{};

  void add(std::uint32_t y, std::uint32_t x, const SampleRange& samples, PixelSums& pixel) {
    ExcludedSamples here{y, x, 0, 0};
    for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
      const std::uint64_t bits = scrambled((std::uint64_t{y} << 48) | (std::uint64_t{x} << 32) | s);
      ++counts.samples;
      counts.rays += bits >> 61;
      counts.lost += bits >> 58 & 7;
      if ((bits >> 48 & 1023) == 0) {
        here.first = here.count == 0 ? s : here.first;
        ++here.count;
        ++counts.nonfinite;
      } else {
        pixel.add({bits & 0xFFFF, bits >> 16 & 0xFFFF, bits >> 32 & 0xFFFF}, s);
      }
    }
    if (here.count > 0) excluded.push_back(here);
  }
};

/// Makes the cells of a batch. Only their `nanoseconds` may differ between copies.
inline TracedCells made_cells(const CellBatch& batch, std::uint64_t nanoseconds = 7) {
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  TracedCells cells;
  cells.range = batch.range;
  cells.records.resize(batch.range.count() * size);
  for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
    const Cell cell = batch.grid->cell(index);
    const auto ranges = batch.run_samples(index);
    std::vector<PixelSums> sums(cell.pixels());
    Made made;
    for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
      made.add(cell.y, cell.x_begin + i, ranges[i], sums[i]);
    }
    const CellHeader header{made.counts.rays, made.counts.nonfinite, made.counts.lost, nanoseconds};
    std::byte* const record = cells.records.data() + (index - batch.range.begin) * size;
    std::memcpy(record, &header, sizeof header);
    std::memcpy(record + sizeof header, sums.data(), sums.size() * sizeof(PixelSums));
    cells.samples += made.counts.samples;
    cells.excluded.insert(cells.excluded.end(), made.excluded.begin(), made.excluded.end());
  }
  std::sort(cells.excluded.begin(), cells.excluded.end());
  return cells;
}

inline std::vector<std::byte> made_records(const WorkPlan& plan, const CellRange& range,
                                           std::uint64_t nanoseconds = 7) {
  return made_cells(plan.batch(range), nanoseconds).records;
}

/// Adds samples of all pixels in image order, without a plan.
inline void make_into(Framebuffer& framebuffer, const std::vector<SampleRange>& ranges) {
  Made made;
  for (std::size_t pixel = 0; pixel < ranges.size(); ++pixel) {
    const auto y = static_cast<std::uint32_t>(pixel / framebuffer.width());
    const auto x = static_cast<std::uint32_t>(pixel % framebuffer.width());
    PixelSums sums;
    made.add(y, x, ranges[pixel], sums);
    framebuffer.add(y, x, {&sums, 1}, RunSamples(ranges[pixel]));
  }
  framebuffer.add(made.counts);
  for (const ExcludedSamples& some : made.excluded) framebuffer.exclude(some);
}

/// Makes all samples of a picture without passes.
inline Framebuffer made_framebuffer(const RenderSettings& settings) {
  Framebuffer framebuffer(settings.width, settings.height);
  make_into(framebuffer,
            std::vector<SampleRange>(framebuffer.pixels().size(), {0, settings.samples_per_pixel}));
  return framebuffer;
}

inline bool same_sums(const Framebuffer& a, const Framebuffer& b) {
  const auto alike = [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.first == y.second.first &&
           x.second.count == y.second.count;
  };
  return std::ranges::equal(a.pixels(), b.pixels()) && a.counts() == b.counts() &&
         std::ranges::equal(a.samples(), b.samples()) &&
         std::equal(a.excluded().begin(), a.excluded().end(), b.excluded().begin(),
                    b.excluded().end(), alike);
}

/// Returns random ranges of further samples: for each pixel none, a few or, rarely, very many.
inline std::vector<SampleRange> ragged_ranges(Dice& dice, const std::vector<std::uint32_t>& before,
                                              std::uint32_t most) {
  std::vector<SampleRange> ranges;
  for (const std::uint32_t count : before) {
    const std::uint32_t more =
        dice.one_in(3) ? 0 : dice.below32(dice.one_in(20) ? most : most / 16 + 2);
    ranges.push_back({count, count + more});
  }
  return ranges;
}

/// Memory for a window, filled with zeros and aligned to words.
class WindowMemory {
 public:
  explicit WindowMemory(std::size_t bytes) : words_((bytes + 7) / 8), bytes_(bytes) {}
  [[nodiscard]] std::span<std::byte> bytes() {
    return std::as_writable_bytes(std::span(words_)).first(bytes_);
  }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t bytes_;
};

/// Returns a window by requests. Its owner has `memory` and performs every request at once.
inline RequestWindow request_window(std::span<std::byte> memory) {
  return RequestWindow([memory](const WindowRequest& request, std::span<const std::byte> bytes) {
    return perform(request, memory,
                   [&](std::span<std::byte> target) { std::ranges::copy(bytes, target.begin()); });
  });
}

/// Returns the tracer of cells that were traced in an earlier mpirun.
inline TracerKey earlier_tracer() { return tracer_key("an earlier mpirun", ""); }

/// Returns "host0", "host1" ...: every rank has its own machine.
inline std::vector<std::string> hosts_apart(std::uint32_t ranks) {
  std::vector<std::string> hosts;
  for (std::uint32_t rank = 0; rank < ranks; ++rank) hosts.push_back("host" + std::to_string(rank));
  return hosts;
}

/// A pass of a picture over a window in this process, with rank 0's part.
struct WindowRig {
  /// `done` lists cells that an earlier run has finished.
  explicit WindowRig(const RenderSettings& its_settings, std::uint32_t ranks = 3,
                     std::uint32_t tile = 0, const std::vector<CellRange>& done = {},
                     const std::vector<std::string>& hosts = {})
      : settings(its_settings),
        picture(settings, SceneFacts(small_scene()), {}, tile),
        pass(begin(done)),
        layout(*plan().grid(), ranks),
        memory(layout.bytes()),
        window(memory.bytes()),
        judge(picture, rank_voices(hosts.empty() ? hosts_apart(ranks) : hosts),
              {.trace = [this](const CellBatch& cell) { return trace_in_rank_0(cell); },
               .retracted =
                   [this](const std::vector<CellRange>& cells) {
                     retracted.insert(retracted.end(), cells.begin(), cells.end());
                     log.push_back(picture.retraction_entry(cells));
                   },
               .restarted = [this] { ++restarts; }}),
        collector(picture, judge, layout, window, memory.bytes(), Time(0), totals,
                  {[](const CellBatch& cell) { return made_cells(cell).excluded; },
                   [this](TracerKey tracer, TracedCells cells) {
                     keep(tracer, cells);
                     merged.push_back(std::move(cells));
                   }}) {}

  [[nodiscard]] const WorkPlan& plan() const { return *pass.plan; }
  WindowSource source(const WindowOptions& options = {}) {
    return {job, pass, layout, window, options};
  }
  WindowSource source_of(std::uint32_t rank) { return source({.rank = rank}); }
  /// Stores cells in the log for a later run.
  void keep(TracerKey tracer, const TracedCells& cells) {
    log.push_back(
        picture.cells_entry(tracer, cells.range, pack_cells(cells, *picture.plan()->grid())));
  }
  bool collect(Time now = Time(0)) { return collector.collect(now, std::uint64_t{1} << 40); }

  RenderSettings settings;
  JobPicture picture;
  RankJob job{settings, "made up", nullptr};
  RankPass pass;
  WindowLayout layout;
  WindowMemory memory;
  LocalWindow window;
  WindowCollector::Totals totals;
  std::vector<TracedCells> merged;
  std::vector<CellRange> retracted;
  std::vector<std::string> log;  ///< entries of the job's log
  std::uint64_t restarts = 0;
  std::uint64_t traced_in_rank_0 = 0;  ///< cells that rank 0 traced to decide disputes
  bool rank_0_lies = false;
  RankJudge judge;
  WindowCollector collector;

 private:
  TracedCells trace_in_rank_0(const CellBatch& cell) {
    ++traced_in_rank_0;
    TracedCells traced = made_cells(cell);
    traced.records[0] ^= static_cast<std::byte>(rank_0_lies ? 1 : 0);
    return traced;
  }
  RankPass begin(const std::vector<CellRange>& done) {
    picture.begin_pass();
    for (const CellRange& range : done) {
      picture.collector().take(earlier_tracer(), made_cells(picture.plan()->batch(range)));
    }
    return {picture.plan(), CellList(picture.collector().missing())};
  }
};

class ManualClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override { return now_; }
  void go_on(Time by) { now_ += by; }

 private:
  Time now_{};
};

/// A team of made-up samples, which takes the time of a machine with `samples_per_second`.
class MadeTeam final : public Team {
 public:
  MadeTeam(const Clock& clock, double samples_per_second)
      : clock_(clock), speed_(samples_per_second) {}

  void start(LeaseWork assignment) override {
    began_ = clock_.now();
    samples_ = static_cast<double>(assignment.cells.sample_count());
    lease_ = std::move(assignment);
    ++started_;
  }
  [[nodiscard]] bool idle() const override { return !lease_; }
  std::optional<LeaseResult> take() override {
    if (!lease_ || clock_.now() < due()) return {};
    const LeaseWork lease = *std::exchange(lease_, std::nullopt);
    LeaseResult finished;
    finished.job = lease.job;
    finished.epoch = lease.epoch;
    finished.grid = lease.cells.grid;
    if (!failure.empty()) {
      finished.failure = failure;
      return finished;
    }
    TracedCells cells = made_cells(lease.cells, static_cast<std::uint64_t>(clock_.now().count()));
    cells.seconds = samples_ / speed_;
    traced_ += cells.samples;
    finished.cells = std::make_shared<const TracedCells>(std::move(cells));
    finished.build_seconds = 0.25;
    finished.accelerator_bytes = 1234;
    return finished;
  }
  void abandon() override { lease_.reset(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool preparing() const override { return false; }

  /// Returns the time when the current lease is done; `never` without a lease.
  [[nodiscard]] Time due() const {
    if (!lease_) return never;
    return began_ + from_seconds(samples_ / speed_);
  }
  [[nodiscard]] std::uint64_t started() const { return started_; }
  [[nodiscard]] const std::optional<LeaseWork>& lease() const { return lease_; }

  std::string failure;  ///< failure of all leases that end from now on; empty: none

 private:
  const Clock& clock_;
  double speed_;
  Time began_{};
  double samples_ = 0;
  std::uint64_t traced_ = 0;
  std::uint64_t started_ = 0;
  std::optional<LeaseWork> lease_;
};

}  // namespace parray::test
