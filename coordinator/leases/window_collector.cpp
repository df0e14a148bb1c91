#include "coordinator/leases/window_collector.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "common/base/bands.h"
#include "common/base/divide_up.h"

namespace parray::coordinator {
namespace {

using Word = WindowLayout::Word;

/// The bytes of a result may arrive after its entry. No network takes longer than this.
constexpr Time arrival_time = seconds(2);

/// No copies are issued before this, because ranks normally end within a few milliseconds.
constexpr Time copy_delay = milliseconds(5);

/// Largest copy. Missing cells are cut into enough copies for all ranks.
constexpr std::uint64_t most_copy_cells = 1024;

/// A thread checks and merges a cell in about 0.1 us and traces it in 200 us. If there are more
/// threads than this per thread of rank 0, merging takes about half of rank 0's time.
constexpr std::uint64_t many_threads = 512;
/// This many threads keep one merging thread about half busy.
constexpr std::uint64_t threads_for_one = 1024;

/// After this time without results rank 0 traces, too.
constexpr Time idle_time = seconds(1);

/// Fewer entries than this are not worth a second thread.
constexpr std::size_t least_parallel_entries = 4;

/// Most cells that rank 0 traces again before it serves other ranks.
constexpr std::uint64_t most_rechecks = 8;

}  // namespace

static std::uint32_t merging_threads_of(const RankThreads& threads) {
  const std::uint64_t wanted = divide_up(threads.all, threads_for_one);
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(wanted, 1, threads.own));
}

WindowCollector::WindowCollector(JobPicture& picture, RankJudge& judge, const WindowLayout& layout,
                                 Window& window, std::span<const std::byte> memory, Time now,
                                 Totals& totals, Hooks hooks, RankThreads threads)
    : picture_(picture),
      judge_(judge),
      plan_(picture.plan()),
      layout_(layout),
      window_(window),
      memory_(memory),
      totals_(totals),
      hooks_(std::move(hooks)),
      many_ranks_(threads.all > many_threads * threads.own),
      merging_threads_(many_ranks_ ? threads.own : merging_threads_of(threads)),
      last_entry_(now),
      lives_(layout.ranks(), Life{0, now}),
      last_life_(now) {
  totals_.row_nanoseconds.resize(picture.framebuffer().height());
  stop_faulty_ranks();
}

/// atomic_ref needs non-const words, but load() does not write.
std::uint64_t WindowCollector::load(std::size_t word) const {
  auto* const words =
      const_cast<std::uint64_t*>(reinterpret_cast<const std::uint64_t*>(memory_.data()));
  return std::atomic_ref(words[word]).load();
}

bool WindowCollector::collect(Time now, std::uint64_t most_cells) {
  find_entries(now);
  const std::uint64_t before = totals_.entries;
  const std::size_t count = entries_of(most_cells);
  behind_ = count < waiting_.size();
  std::vector<char> read(count);
  const bool together = merging_threads() > 1 && count >= least_parallel_entries;
  if (together) {
    side_by_side(count, static_cast<int>(merging_threads()),
                 [&](std::size_t i) { read[i] = read_entry(now, waiting_[i]) ? 1 : 0; });
  } else {
    for (std::size_t i = 0; i < count; ++i) read[i] = read_entry(now, waiting_[i]) ? 1 : 0;
  }
  // Entries that must wait move to the end, so that they do not block others.
  std::vector<Entry> left(waiting_.begin() + static_cast<std::ptrdiff_t>(count), waiting_.end());
  for (std::size_t i = 0; i < count; ++i) {
    if (read[i] == 0) left.push_back(waiting_[i]);
  }
  waiting_ = std::move(left);
  if (judge_.has_rechecks()) judge_.recheck(most_rechecks);
  stop_faulty_ranks();
  if (totals_.entries == before) return false;
  last_entry_ = last_life_ = now;
  return true;
}

/// Finds new entries of every block.
void WindowCollector::find_entries(Time now) {
  const std::uint64_t claimed = std::min(
      layout_.ranks() + std::min(load(Word::log_head), layout_.log_blocks()), layout_.log_blocks());
  for (; claimed_blocks_ < claimed; ++claimed_blocks_) {
    const std::uint64_t first = claimed_blocks_ * WindowLayout::block_entries;
    blocks_.push_back({first, first + WindowLayout::block_entries});
  }
  std::erase_if(blocks_, [&](Block& block) {
    for (; block.next < block.end && load(layout_.log_word(block.next)) != 0; ++block.next) {
      waiting_.push_back({block.next, now});
    }
    return block.next == block.end;
  });
}

/// Finds entries behind a missing one, which may have been lost in transit.
void WindowCollector::find_gaps(Time now) {
  for (Block& block : blocks_) {
    std::uint64_t end = block.end;
    while (end > block.next && load(layout_.log_word(end - 1)) == 0) --end;
    for (; block.next < end; ++block.next) waiting_.push_back({block.next, now});
  }
}

/// Returns how many waiting entries have about `most_cells` cells together.
std::size_t WindowCollector::entries_of(std::uint64_t most_cells) {
  std::uint64_t cells = 0;
  std::size_t count = 0;
  for (; count < waiting_.size() && cells < most_cells; ++count) {
    cells += range_from_word(load(layout_.log_word(waiting_[count].index))).count();
  }
  return count;
}

bool WindowCollector::wants_all_threads(Time now) const {
  return many_ranks_ && now - last_entry_ < idle_time;
}

/// Handles an entry. Returns false if its bytes may still arrive. Any thread may call it.
bool WindowCollector::read_entry(Time now, const Entry& entry) {
  const std::size_t first = layout_.log_word(entry.index);
  const std::uint64_t word = load(first);
  if (word == 0) return false;
  // The number of a rank is 0 - 1 if it has not arrived yet.
  const std::uint64_t rank = load(first + 2) - 1;
  if (rank < layout_.ranks() &&
      take(static_cast<std::uint32_t>(rank), range_from_word(word), load(first + 1))) {
    return true;
  }
  if (now - entry.since < arrival_time) return false;
  const std::scoped_lock lock(mutex_);
  ++totals_.corrupt;  // its cells stay missing, so that a rank traces them again
  return true;
}

/// Copies, checks and merges a result. (A rank that traces a cell again may overwrite its bytes.)
bool WindowCollector::take(std::uint32_t rank, const CellRange& range, std::uint64_t digest) {
  if (range.begin >= range.end || range.end > plan_->cells()) return false;
  const auto there =
      memory_.subspan(layout_.record_offset(range.begin), range.count() * layout_.record_bytes());
  TracedCells traced;
  traced.range = range;
  traced.records.assign(there.begin(), there.end());
  std::vector<std::uint64_t> digests = cell_digests(traced.records, layout_.record_bytes());
  if (entry_digest(range_digest(digests), rank) != digest) return false;
  const std::vector<Cell> cells = plan_->grid()->cells_of(range);
  if (!complete(traced, cells)) return false;
  merge(rank, std::move(traced), std::move(digests), cells);
  return true;
}

/// Returns the runs of merged cells of a range.
std::vector<CellRange> WindowCollector::cells_in(const CellRange& range) const {
  std::vector<CellRange> in;
  for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
    if (!picture_.collector().has(cell)) continue;
    if (!in.empty() && in.back().end == cell) {
      ++in.back().end;
    } else {
      in.push_back({cell, cell + 1});
    }
  }
  return in;
}

/// Stops the ranks of new findings.
void WindowCollector::stop_faulty_ranks() {
  const std::vector<RankJudge::Verdict>& verdicts = judge_.verdicts();
  for (; verdicts_applied_ < verdicts.size(); ++verdicts_applied_) {
    for (const std::uint32_t rank : verdicts[verdicts_applied_].left_out) {
      window_.store(WindowLayout::rank_word(rank, WindowLayout::stop), 1);
    }
  }
}

/// Drops results of faulty ranks and of an obsolete plan.
void WindowCollector::merge(std::uint32_t rank, TracedCells traced,
                            std::vector<std::uint64_t> digests, std::span<const Cell> cells) {
  const std::scoped_lock lock(mutex_);
  if (overtaken() || judge_.left_out(rank)) return;
  ResultCollector& collector = picture_.collector();
  if (const auto in = cells_in(traced.range); !in.empty()) {
    const std::vector<std::uint64_t> whole = collector.digests_of(traced);
    totals_.mismatches += collector.compare(traced.range, whole).mismatches;
    if (!judge_.admit(rank, traced, whole)) return;
    judge_.note_checks(rank, cells_in(traced.range));
  }
  for (std::uint64_t i = 0; i < cells.size(); ++i) {
    if (!collector.has(traced.range.begin + i)) {
      const auto record = std::span(traced.records).subspan(i * layout_.record_bytes());
      totals_.row_nanoseconds[cells[i].y] += header_of(record).nanoseconds;
    }
  }
  const TracerKey tracer = judge_.tracer(rank);
  const ResultCollector::Taken taken = collector.take(tracer, traced, std::move(digests), cells);
  ++totals_.entries;
  totals_.duplicates += taken.duplicates;
  if (taken.fresh > 0 && hooks_.merged) hooks_.merged(tracer, std::move(traced));
}

/// Adds the values that a window does not transport. Returns false if the numbers are impossible.
bool WindowCollector::complete(TracedCells& traced, std::span<const Cell> cells) {
  const CellBatch batch = plan_->batch(traced.range);
  traced.samples = batch.sample_count(cells);
  for (std::uint64_t i = 0; hooks_.locate && i < traced.range.count(); ++i) {
    const auto record = std::span(traced.records).subspan(i * layout_.record_bytes());
    if (header_of(record).nonfinite > 0) {
      const std::uint64_t cell = traced.range.begin + i;
      const std::scoped_lock lock(mutex_);
      const auto found = hooks_.locate(plan_->batch({cell, cell + 1}));
      traced.excluded.insert(traced.excluded.end(), found.begin(), found.end());
    }
  }
  std::ranges::sort(traced.excluded);
  return fault_of(traced, batch, cells, max_depth_of(picture_.settings())).empty();
}

void WindowCollector::finish() {
  for (std::uint32_t rank = 0; overtaken() && rank < layout_.ranks(); ++rank) {
    window_.store(WindowLayout::rank_word(rank, WindowLayout::stop), 1);
  }
  window_.store(Word::finished, 1);
}

void WindowCollector::issue_copies(Time now) {
  const std::uint64_t copy_requests =
      std::min(load(Word::copy_requests), WindowLayout::most_copies);
  if (copy_requests > copies_issued_ && waiting_since_ == never) find_gaps(now);
  // Cells of unread entries may be done already.
  if (copy_requests <= copies_issued_ || behind_ || overtaken() || picture_.collector().done()) {
    waiting_since_ = never;
    return;
  }
  waiting_since_ = std::min(waiting_since_, now);
  if (now - waiting_since_ < copy_delay || now < next_round_) return;
  const std::uint64_t left = picture_.plan()->cells() - picture_.collector().done_cells();
  const std::uint64_t most =
      std::clamp<std::uint64_t>(left / (2ULL * layout_.ranks()), 1, most_copy_cells);
  while (copies_issued_ < copy_requests) {
    if (copy_cursor_ == 0) round_began_ = now;
    const CellRange range = picture_.collector().next_missing(copy_cursor_, most);
    if (range.count() == 0) {  // the round is over
      copy_cursor_ = 0;
      next_round_ = now + std::max(2 * (now - round_began_), Time(milliseconds(50)));
      break;
    }
    copy_cursor_ = range.end;
    window_.store(layout_.copy_word(copies_issued_), to_word(range));
    ++copies_issued_;
    ++totals_.copies;
  }
  window_.store(Word::copies, copies_issued_);
}

std::uint64_t WindowCollector::activity() const {
  return load(Word::step) + load(Word::position) + load(Word::copy_requests) + totals_.entries;
}

void WindowCollector::listen(Time now) {
  window_.fetch_add(Word::root_heartbeat, 1);
  for (std::uint32_t rank = 0; rank < layout_.ranks(); ++rank) {
    const std::uint64_t beat = rank_value(rank, WindowLayout::beat);
    if (beat != lives_[rank].beat) {
      lives_[rank] = {beat, now};
      last_life_ = now;
    }
  }
}

std::vector<std::uint32_t> WindowCollector::silent_ranks(Time now, Time patience) const {
  std::vector<std::uint32_t> silent;
  for (std::uint32_t rank = 0; rank < layout_.ranks(); ++rank) {
    const Life& life = lives_[rank];
    const bool at_work = (life.beat & (beat_flags::tracing | beat_flags::building)) != 0;
    if (at_work && now - life.changed >= patience) silent.push_back(rank);
  }
  return silent;
}

}  // namespace parray::coordinator
