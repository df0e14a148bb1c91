#include "worker/window_source.h"

#include <algorithm>
#include <cmath>

#include "common/base/error.h"

namespace parray {
namespace {

using Word = WindowLayout::Word;

/// Of one result: what one put carries, and what a rank keeps in memory.
constexpr std::size_t most_part_bytes = std::size_t{1} << 25;
/// Seconds of one part: how often a long lease shows progress.
constexpr double part_seconds = 0.5;
/// Samples of a part while the speed is unknown.
constexpr double first_part_samples = 1e6;

constexpr Time beat_interval = milliseconds(250);

}  // namespace

LeaseSource::Taken RankSource::take(Time /*now*/, double samples_per_second, bool idle) {
  const Part part = take_part(samples_per_second, idle);
  if (part.answer != Answer::lease) {
    return {part.answer};
  }
  return {part.answer,
          {0, pass_.number, ++parts_taken_, pass_.plan->batch(part.cells), job_.settings,
           job_.scene_id, job_.scene},
          part.fresh,
          static_cast<double>(part.cells.count()) * pass_.plan->cell_samples()};
}

void RankSource::complete(Time /*now*/, Finished finished) {
  if (!finished.cells) {
    throw RunError("tracing: " + finished.failure);
  }
  job_.scene.reset();  // the team has what it needs
  put(finished.cells->range, finished.cells->records);
}

Time RankSource::tick(Time now, const TeamState& team) {
  if (now >= next_beat_) {
    next_beat_ = now + beat_interval;
    publish(WindowLayout::beat, team.traced | (team.tracing ? beat_flags::tracing : 0) |
                                    (team.preparing ? beat_flags::building : 0));
  }
  return next_beat_;
}

void RankSource::report(const WorkTally& tally) {
  const auto nanoseconds = [](double s) { return static_cast<std::uint64_t>(s * 1e9); };
  publish(WindowLayout::samples, tally.samples);
  publish(WindowLayout::busy, nanoseconds(tally.busy));
  publish(WindowLayout::takes, tally.leases);
  publish(WindowLayout::taking, static_cast<std::uint64_t>(tally.taking.count()));
  publish(WindowLayout::putting, static_cast<std::uint64_t>(tally.putting.count()));
  publish(WindowLayout::build, nanoseconds(tally.build_seconds));
  publish(WindowLayout::tree_bytes, tally.accelerator_bytes);
}

WindowSource::WindowSource(RankJob& job, const RankPass& pass, const WindowLayout& layout,
                           Window& window, const WindowOptions& options)
    : RankSource(job, pass),
      plan_(*pass.plan),
      missing_(pass.missing),
      layout_(layout),
      window_(window),
      options_(options),
      sizer_(options.policy, plan_, options.length, missing_.count()) {
  if (options_.policy != SchedulePolicy::weighted) {
    const std::uint32_t each = std::max(options_.all_threads / layout.ranks(), 1U);
    starts_ = sizer_.starts(layout.ranks(), each);  // alike on every rank
  }
}

RankSource::Part WindowSource::take_part(double samples_per_second, bool idle) {
  const bool fresh = parts_.empty();
  if (fresh && !exhausted_) {
    const auto places = options_.policy == SchedulePolicy::weighted
                            ? take_weighted(samples_per_second)
                            : take_step();
    exhausted_ = !places;
    if (places) {
      cut(*places, samples_per_second);
    }
  }
  if (!parts_.empty()) {
    const CellRange part = parts_.front();
    parts_.pop_front();
    return {Answer::lease, part, fresh};
  }
  return idle ? take_copy() : Part{Answer::wait, {}};
}

/// At gaps, and into parts of equal length that one result can hold.
void WindowSource::cut(const CellRange& places, double samples_per_second) {
  const double samples =
      samples_per_second > 0 ? samples_per_second * part_seconds : first_part_samples;
  const auto by_time = static_cast<std::uint64_t>(samples / plan_.cell_samples());
  const std::uint64_t most = std::clamp<std::uint64_t>(
      std::min<std::uint64_t>(by_time, most_part_bytes / layout_.record_bytes()), 1,
      most_cells_in_word);
  for (const CellRange& run : missing_.cells_at(places)) {
    const std::uint64_t parts = (run.count() + most - 1) / most;
    for (std::uint64_t part = 0; part < parts; ++part) {
      parts_.push_back(
          {run.begin + run.count() * part / parts, run.begin + run.count() * (part + 1) / parts});
    }
  }
}

std::optional<CellRange> WindowSource::take_step() {
  const std::uint64_t step = window_.fetch_add(Word::step, 1);
  if (step + 1 >= starts_.size()) {
    return {};
  }
  return CellRange{starts_[step], starts_[step + 1]};
}

/// What is left is read first, so that a chunk can be half of this rank's share of it; others may
/// take some in between, which only makes the chunk larger than it would have been.
std::optional<CellRange> WindowSource::take_weighted(double samples_per_second) {
  const SpeedSum sum = publish_speed(samples_per_second);
  const std::uint64_t position = window_.load(Word::position);
  const std::uint64_t total = missing_.count();
  if (position >= total) {
    return {};
  }
  const FarmSpeed farm{1e3 * static_cast<double>(sum.kilosamples), sum.threads,
                       options_.all_threads, layout_.ranks()};
  const std::uint64_t cells =
      sizer_.cells({options_.threads, samples_per_second}, farm, total - position, 0);
  const std::uint64_t begin = window_.fetch_add(Word::position, cells);
  if (begin >= total) {
    return {};
  }
  return CellRange{begin, std::min(begin + cells, total)};
}

/// Puts this rank's speed into the sum of all and returns the sum.
SpeedSum WindowSource::publish_speed(double samples_per_second) {
  SpeedSum own;
  if (samples_per_second > 0) {
    own = {options_.threads, static_cast<std::uint64_t>(std::ceil(samples_per_second / 1e3))};
  }
  // Modulo 2^64 the difference of two words is right even when its lower part is negative.
  const std::uint64_t delta = own.word() - published_.word();
  published_ = own;
  return SpeedSum::from_word(window_.fetch_add(Word::speed, delta) + delta);
}

RankSource::Part WindowSource::take_copy() {
  if (!ticket_) {
    ticket_ = window_.fetch_add(Word::tickets, 1);
  }
  if (window_.load(Word::finished) != 0) {
    return {Answer::over, {}};
  }
  if (*ticket_ >= layout_.most_copies() || window_.load(Word::copies) <= *ticket_) {
    return {Answer::wait, {}};
  }
  const CellRange cells = range_from_word(window_.load(layout_.copy_word(*ticket_)));
  ticket_.reset();
  return {Answer::lease, cells};
}

void WindowSource::put(const CellRange& cells, std::span<const std::byte> records) {
  window_.put(layout_.record_offset(cells.begin), records);
  log(cells, range_digest(cell_digests(records, layout_.record_bytes())));
}

void WindowSource::log(const CellRange& cells, std::uint64_t digest) {
  const std::uint64_t entry = window_.fetch_add(Word::log_head, 1);
  if (entry >= layout_.most_log_entries()) {
    return;  // only after thousands of copies of copies: nobody waits for this one alone
  }
  window_.store(layout_.log_word(entry) + 1, digest);
  window_.store(layout_.log_word(entry), to_word(cells));  // last: it makes the entry valid
}

void WindowSource::publish(WindowLayout::RankWord word, std::uint64_t value) {
  window_.store(WindowLayout::rank_word(options_.rank, word), value);
}

}  // namespace parray
