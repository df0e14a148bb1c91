#include "worker/window_leases.h"

#include <algorithm>
#include <cmath>

namespace parray {

using Word = WindowLayout::Word;

WindowLeases::WindowLeases(const WorkPlan& plan, const WindowLayout& layout, Window& window,
                           const WindowLeaseOptions& options)
    : plan_(plan), layout_(layout), window_(window), options_(options) {
  if (options_.policy != SchedulePolicy::weighted && plan.cells() > 0) {
    ChunkRequest job;
    job.total = plan.cells();
    job.row_units = plan.cells_per_row();
    job.workers = layout.ranks();
    job.threads = std::max(options_.all_threads / layout.ranks(), 1U);  // alike on every rank
    starts_ = chunk_starts(options_.policy, job);
  }
}

LeaseSource::Taken WindowLeases::take(double samples_per_second, bool idle) {
  if (!exhausted_) {
    const auto range = options_.policy == SchedulePolicy::weighted
                           ? take_weighted(samples_per_second)
                           : take_step();
    if (range) {
      return {Answer::lease, *range};
    }
    exhausted_ = true;
  }
  return idle ? take_copy() : Taken{Answer::wait, {}};
}

std::optional<CellRange> WindowLeases::take_step() {
  const std::uint64_t step = window_.fetch_add(Word::step, 1);
  if (step + 1 >= starts_.size()) {
    return {};
  }
  return CellRange{starts_[step], starts_[step + 1]};
}

/// What is left is read first, so that a chunk can be half of this rank's share of it; others may
/// take some in between, which only makes the chunk larger than it would have been.
std::optional<CellRange> WindowLeases::take_weighted(double samples_per_second) {
  const SpeedSum all = publish_speed(samples_per_second);
  const std::uint64_t position = window_.load(Word::position);
  if (position >= plan_.cells()) {
    return {};
  }
  // A rank that is not measured yet counts as fast, a thread, as those that are.
  const double per_thread = all.threads > 0 ? 1e3 * static_cast<double>(all.kilosamples) /
                                                  static_cast<double>(all.threads)
                                            : 1;
  const double speed = samples_per_second > 0 ? samples_per_second : per_thread * options_.threads;
  // A first lease only measures: about 10 ms on a core of 10 M samples/s.
  constexpr double first_lease_samples = 1e5;
  const double cell = plan_.cell_samples();
  const double most = samples_per_second > 0 ? speed * options_.longest_seconds
                                             : first_lease_samples * options_.threads;
  const double least = samples_per_second * options_.shortest_seconds;
  ChunkRequest request;
  request.total = plan_.cells();
  request.remaining = plan_.cells() - position;
  request.share = std::clamp(speed / (per_thread * options_.all_threads), 1e-9, 1.0);
  request.least = std::max<std::uint64_t>(static_cast<std::uint64_t>(least / cell),
                                          std::uint64_t{options_.threads} * plan_.piece_cells());
  request.most = std::max(static_cast<std::uint64_t>(most / cell), request.least);
  const std::uint64_t cells = chunk_units(SchedulePolicy::weighted, request);
  const std::uint64_t begin = window_.fetch_add(Word::position, cells);
  if (begin >= plan_.cells()) {
    return {};
  }
  return CellRange{begin, std::min(begin + cells, plan_.cells())};
}

/// Puts this rank's speed into the sum of all and returns the sum.
SpeedSum WindowLeases::publish_speed(double samples_per_second) {
  SpeedSum own;
  if (samples_per_second > 0) {
    own = {options_.threads, static_cast<std::uint64_t>(std::ceil(samples_per_second / 1e3))};
  }
  // Modulo 2^64 the difference of two words is right even when its lower part is negative.
  const std::uint64_t delta = own.word() - published_.word();
  published_ = own;
  return SpeedSum::from_word(window_.fetch_add(Word::speed, delta) + delta);
}

LeaseSource::Taken WindowLeases::take_copy() {
  if (!ticket_) {
    ticket_ = window_.fetch_add(Word::tickets, 1);
  }
  if (window_.load(Word::finished) != 0) {
    return {Answer::over, {}};
  }
  if (*ticket_ >= layout_.most_copies() || window_.load(Word::copies) <= *ticket_) {
    return {Answer::wait, {}};
  }
  const CellRange range = range_from_word(window_.load(layout_.copy_word(*ticket_)));
  ticket_.reset();
  return {Answer::lease, range};
}

void WindowLeases::complete(const CellRange& range, std::span<const std::byte> records) {
  window_.put(layout_.record_offset(range.begin), records);
  log(range, range_digest(cell_digests(records, layout_.record_bytes())));
}

void WindowLeases::log(const CellRange& range, std::uint64_t digest) {
  const std::uint64_t entry = window_.fetch_add(Word::log_head, 1);
  if (entry >= layout_.most_log_entries()) {
    return;  // only after thousands of copies of copies: nobody waits for this one alone
  }
  window_.store(layout_.log_word(entry) + 1, digest);
  window_.store(layout_.log_word(entry), to_word(range));  // last: it makes the entry valid
}

void WindowLeases::tell(WindowLayout::RankWord word, std::uint64_t value) {
  window_.store(WindowLayout::rank_word(options_.rank, word), value);
}

}  // namespace parray
