#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/image/framebuffer.h"
#include "common/schedule/row_order.h"
#include "common/schedule/work_plan.h"
#include "proto/clock.h"
#include "proto/window.h"
#include "tests/support/dice.h"
#include "worker/cell_team.h"

/// A job over a window without a tracer: its samples are made-up numbers, which depend on row,
/// column and sample alone, so that what must come out can be added up without a plan.
namespace parray::test {

inline RenderSettings made_settings(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.row_order = RowOrder::interleaved;
  return settings;
}

/// Scrambles a number (the finalizer of SplitMix64).
inline std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  return x ^ (x >> 31);
}

inline void add_made_sample(std::uint32_t position, std::uint32_t x, std::uint32_t sample,
                            PixelSums& pixel, TraceCounts& counts) {
  const std::uint64_t bits =
      scrambled((std::uint64_t{position} << 48) | (std::uint64_t{x} << 32) | sample);
  pixel.add({bits & 0xFFFF, bits >> 16 & 0xFFFF, bits >> 32 & 0xFFFF}, sample);
  ++counts.samples;
  counts.rays += bits >> 60;
  counts.nonfinite += bits >> 48 & 1;
  counts.lost += bits >> 49 & 7;
}

/// The record of a cell; `nanoseconds` is the one thing that may differ between copies.
inline std::vector<std::byte> made_record(const WorkPlan& plan, std::uint64_t index,
                                          std::uint64_t nanoseconds) {
  const Cell cell = plan.cell(index);
  std::vector<PixelSums> pixels(plan.cell_pixels());
  TraceCounts counts;
  for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
    const SampleRange samples = cell.samples_of(i);
    for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
      add_made_sample(cell.position, cell.x_begin + i, s, pixels[i], counts);
    }
  }
  const CellHeader header{counts.rays, counts.nonfinite, counts.lost, nanoseconds};
  std::vector<std::byte> record(record_bytes_of(plan));
  std::memcpy(record.data(), &header, sizeof header);
  std::memcpy(record.data() + sizeof header, pixels.data(), pixels.size() * sizeof(PixelSums));
  return record;
}

inline std::vector<std::byte> made_records(const WorkPlan& plan, const CellRange& range,
                                           std::uint64_t nanoseconds = 7) {
  std::vector<std::byte> records;
  for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
    const auto record = made_record(plan, cell, nanoseconds);
    records.insert(records.end(), record.begin(), record.end());
  }
  return records;
}

/// The made-up samples of a rectangle of work; `samples`: what each of its pixels has, empty: all.
inline RowBlock made_block(const RenderSettings& settings, const WorkRect& rect,
                           const std::vector<SampleRange>& samples = {}) {
  RowBlock block{rect, settings.width, {}, {}};
  for (std::uint32_t row = rect.row_begin; row < rect.row_end; ++row) {
    for (std::uint32_t x = 0; x < settings.width; ++x) {
      const SampleRange own = samples.empty() ? rect.sample_range() : samples[block.pixels.size()];
      PixelSums& pixel = block.pixels.emplace_back();
      for (std::uint32_t s = own.begin; s < own.end; ++s) {
        add_made_sample(row, x, s, pixel, block.counts);
      }
    }
  }
  return block;
}

/// The made-up samples of some rectangles in a framebuffer.
inline Framebuffer made_framebuffer(const RenderSettings& settings,
                                    const std::vector<WorkRect>& rects) {
  Framebuffer framebuffer(settings);
  for (const WorkRect& rect : rects) {
    framebuffer.merge(made_block(settings, rect));
  }
  return framebuffer;
}

inline bool same_sums(const Framebuffer& a, const Framebuffer& b) {
  return a.pixels() == b.pixels() && a.counts() == b.counts() && a.samples() == b.samples();
}

/// Samples of each pixel after a pass that gives some none, most a few and some very many.
inline std::vector<std::uint32_t> ragged_counts(Dice& dice,
                                                const std::vector<std::uint32_t>& before,
                                                std::uint32_t most) {
  std::vector<std::uint32_t> counts = before;
  for (std::uint32_t& count : counts) {
    count += dice.one_in(3) ? 0 : dice.below32(dice.one_in(20) ? most : most / 16 + 2);
  }
  return counts;
}

/// Memory for a window, of zeros, aligned to words.
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

class ManualClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override { return now_; }
  void go_on(Time by) { now_ += by; }

 private:
  Time now_{};
};

/// A team whose made-up samples take the time that a machine of `samples_per_second` would need.
class SimCellTeam final : public CellTeam {
 public:
  SimCellTeam(const WorkPlan& plan, const Clock& clock, double samples_per_second)
      : plan_(plan), clock_(clock), speed_(samples_per_second) {}

  void start(const CellRange& range) override {
    began_ = clock_.now();
    samples_ = 0;
    for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
      samples_ += static_cast<double>(plan_.cell(cell).samples());
    }
    range_ = range;
    ++started_;
  }
  [[nodiscard]] bool busy() const override { return range_.has_value(); }
  std::optional<TracedCells> take() override {
    if (!range_ || clock_.now() < due()) {
      return {};
    }
    traced_ += static_cast<std::uint64_t>(samples_);
    const CellRange range = *std::exchange(range_, std::nullopt);
    const auto time = static_cast<std::uint64_t>(clock_.now().count());
    return TracedCells{range, made_records(plan_, range, time),
                       static_cast<std::uint64_t>(samples_), samples_ / speed_};
  }
  void abandon() override { range_.reset(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool building() const override { return false; }

  /// When the range at hand is done; `never` without one.
  [[nodiscard]] Time due() const {
    if (!range_) {
      return never;
    }
    return began_ +
           std::chrono::duration_cast<Time>(std::chrono::duration<double>(samples_ / speed_));
  }
  [[nodiscard]] std::uint64_t started() const { return started_; }
  [[nodiscard]] const std::optional<CellRange>& range() const { return range_; }

 private:
  const WorkPlan& plan_;
  const Clock& clock_;
  double speed_;
  Time began_{};
  double samples_ = 0;
  std::uint64_t traced_ = 0;
  std::uint64_t started_ = 0;
  std::optional<CellRange> range_;
};

}  // namespace parray::test
