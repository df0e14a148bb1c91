#include "worker/window_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/error.h"

namespace parray::worker {
namespace {

using Word = WindowLayout::Word;

/// Largest result in bytes. It bounds the size of a put and the memory of a rank.
constexpr std::size_t most_part_bytes = std::size_t{1} << 25;
/// Length of a part in seconds. It determines how often a long lease shows progress.
constexpr double part_seconds = 0.5;
/// Samples of a part as long as the speed is unknown.
constexpr double first_part_samples = 1e6;

/// Number of other groups' ledgers that a rank tries, so that not all ranks queue at all ledgers.
constexpr std::uint32_t most_foreign_ledgers = 3;

constexpr Time heartbeat_interval = milliseconds(250);

}  // namespace

LeaseSource::Taken WindowSource::take(Time /*now*/, double samples_per_second, bool idle) {
  const Part part = take_part(samples_per_second, idle);
  if (part.answer != Answer::lease) return {part.answer};
  return {
      part.answer,
      {0, ++parts_taken_, pass_.plan->batch(part.cells), job_.settings, job_.scene_id, job_.scene},
      part.fresh,
      static_cast<double>(part.cells.count()) * pass_.plan->cell_samples()};
}

void WindowSource::complete(Time /*now*/, LeaseResult finished) {
  if (!finished.cells) throw RunError("tracing: " + finished.failure);
  job_.scene.reset();  // the team holds what it needs
  put(finished.cells->range, finished.cells->records);
}

Time WindowSource::tick(Time now, const TeamState& team) {
  if (now >= next_heartbeat_) {
    next_heartbeat_ = now + heartbeat_interval;
    publish(WindowLayout::beat, team.traced | (team.tracing ? beat_flags::tracing : 0) |
                                    (team.preparing ? beat_flags::building : 0));
  }
  return next_heartbeat_;
}

void WindowSource::report(const WorkTally& tally) {
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
                           Window& window, const WindowOptions& options,
                           std::optional<LedgerWindows> ledgers)
    : job_(job),
      pass_(pass),
      plan_(*pass.plan),
      missing_(pass.missing),
      layout_(layout),
      window_(window),
      options_(options),
      sizer_(options.policy, plan_, options.length, missing_.count()),
      ledgers_(ledgers ? std::move(*ledgers)
                       : LedgerWindows{Ledgers(layout.ranks(), layout.ranks()), {&window}}),
      home_(ledgers_.ledgers.home(options.rank)) {
  if (options_.policy != SchedulePolicy::weighted) {
    const std::uint32_t each = std::max(options_.all_threads / layout.ranks(), 1U);
    starts_ = sizer_.starts(layout.ranks(), each);  // equal on every rank
  }
}

WindowSource::Part WindowSource::take_part(double samples_per_second, bool idle) {
  if (stopped_) return {Answer::over, {}};
  const bool fresh = parts_.empty();
  if (fresh && !exhausted_) {
    const auto places = options_.policy == SchedulePolicy::weighted
                            ? take_weighted(samples_per_second)
                            : take_step();
    exhausted_ = !places;
    if (places) cut(*places, samples_per_second);
  }
  if (!parts_.empty()) {
    const CellRange part = parts_.front();
    parts_.pop_front();
    return {Answer::lease, part, fresh};
  }
  return idle ? take_copy() : Part{Answer::wait, {}};
}

/// Cuts a lease at gaps, and into parts of equal length that fit into one result.
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
  if (step + 1 >= starts_.size()) return {};
  return CellRange{starts_[step], starts_[step + 1]};
}

std::optional<CellRange> WindowSource::take_weighted(double samples_per_second) {
  const std::uint32_t most = std::min(ledgers_.ledgers.count(), 1 + most_foreign_ledgers);
  for (; empty_ledgers_ < most; ++empty_ledgers_) {
    if (const auto places = take_from(ledger_after(empty_ledgers_), samples_per_second)) {
      return places;
    }
  }
  return {};
}

/// Returns the ledger to try after `empty` empty ones. Ranks of a group try different ledgers.
std::uint32_t WindowSource::ledger_after(std::uint32_t empty) const {
  const std::uint32_t count = ledgers_.ledgers.count();
  if (empty == 0) return home_;
  return (home_ + 1 + (options_.rank + empty) % (count - 1)) % count;
}

/// Reads the number of remaining cells first, because a chunk is half of this rank's share of them.
/// If other ranks take cells in between, the chunk is a little too large, which does no harm.
std::optional<CellRange> WindowSource::take_from(std::uint32_t ledger, double samples_per_second) {
  Window& window = *ledgers_.windows[ledger];
  const CellRange part = ledgers_.ledgers.part(ledger, missing_.count());
  const std::uint64_t position = window.load(Word::position);
  if (position >= part.count()) return {};
  const SpeedSum sum = speed_of(ledger, samples_per_second);
  const std::uint32_t groups = ledgers_.ledgers.count();
  const FarmSpeed group{1e3 * static_cast<double>(sum.kilosamples), sum.threads,
                        std::max(options_.all_threads / groups, options_.threads),
                        std::max(layout_.ranks() / groups, 1U)};
  const std::uint64_t cells =
      sizer_.cells({options_.threads, samples_per_second}, group, part.count() - position, 0);
  const std::uint64_t taken = window.fetch_add(Word::position, cells);
  if (taken >= part.count()) return {};
  return CellRange{part.begin + taken, part.begin + std::min(taken + cells, part.count())};
}

/// Returns the sum of the speeds of a ledger's ranks, after this rank has updated its own part.
SpeedSum WindowSource::speed_of(std::uint32_t ledger, double samples_per_second) {
  Window& window = *ledgers_.windows[ledger];
  if (samples_per_second <= 0 && published_.threads == 0) {
    return {};  // as long as this rank has no speed, few others have one
  }
  if (ledger != home_) return SpeedSum::from_word(window.load(Word::speed));
  SpeedSum own;
  if (samples_per_second > 0) {
    own = {options_.threads, static_cast<std::uint64_t>(std::ceil(samples_per_second / 1e3))};
  }
  // The difference of two words is correct modulo 2^64, even if its lower part is negative.
  const std::uint64_t delta = own.word() - published_.word();
  published_ = own;
  return SpeedSum::from_word(window.fetch_add(Word::speed, delta) + delta);
}

WindowSource::Part WindowSource::take_copy() {
  if (!ticket_) ticket_ = window_.fetch_add(Word::copy_requests, 1);
  if (window_.load(Word::finished) != 0) return {Answer::over, {}};
  if (*ticket_ >= WindowLayout::most_copies || window_.load(Word::copies) <= *ticket_) {
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
  if (entries_left_ == 0) {
    const std::uint64_t block = std::exchange(first_block_, false)
                                    ? options_.rank
                                    : layout_.ranks() + window_.fetch_add(Word::log_head, 1);
    if (block >= layout_.log_blocks()) {
      return;  // only after thousands of copies of copies, so other ranks trace the cells, too
    }
    next_entry_ = block * WindowLayout::block_entries;
    entries_left_ = WindowLayout::block_entries;
  }
  // One put writes the whole entry. A reader of a half-written entry finds a wrong digest.
  const std::array entry = {to_word(cells), entry_digest(digest, options_.rank),
                            std::uint64_t{options_.rank} + 1};
  window_.put(layout_.log_word(next_entry_) * sizeof digest, std::as_bytes(std::span(entry)));
  ++next_entry_;
  --entries_left_;
}

void WindowSource::publish(WindowLayout::RankWord word, std::uint64_t value) {
  window_.store(WindowLayout::rank_word(options_.rank, word), value);
  if (word == WindowLayout::beat) {
    stopped_ =
        stopped_ || window_.load(WindowLayout::rank_word(options_.rank, WindowLayout::stop)) != 0;
  }
}

}  // namespace parray::worker
