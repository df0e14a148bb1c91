#include "coordinator/leases/window_collector.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "common/base/bands.h"
#include "common/base/divide_up.h"

namespace parray::coordinator {
namespace {

using Word = WindowLayout::Word;

/// Bytes on their way may arrive after the entry that speaks of them; longer than any network
/// takes.
constexpr Time arrival_time = seconds(2);

/// Ranks end within a few milliseconds of each other anyway.
constexpr Time hunger_time = milliseconds(5);

/// A copy is one entry of the log, so it is small; what is left is cut into enough of them.
constexpr std::uint64_t most_copy_cells = 1024;

/// To check and merge a cell takes a thread some 0.1 us, to trace it 200: of more threads than this
/// many times its own, rank 0 has enough to do with half of its time.
constexpr std::uint64_t many_threads = 512;
/// As many give one thread about half a thread's work.
constexpr std::uint64_t threads_for_one = 1024;

/// Without results for so long, rank 0 traces too.
constexpr Time quiet_time = seconds(1);

/// What wakes another thread.
constexpr std::size_t least_parallel_entries = 4;

/// Rank 0 traces at most so many cells again before it serves other ranks.
constexpr std::uint64_t most_rechecks = 8;

}  // namespace

static std::uint32_t crew_of(const RankThreads& threads) {
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
      crew_(many_ranks_ ? threads.own : crew_of(threads)),
      last_entry_(now),
      lives_(layout.ranks(), Life{0, now}),
      last_life_(now) {
  totals_.row_nanoseconds.resize(picture.framebuffer().height());
  stop_faulty_ranks();
}

/// Words are not const for atomic_ref, but nothing is written.
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
  const bool together = crew() > 1 && count >= least_parallel_entries;
  if (together) {
    side_by_side(count, static_cast<int>(crew()),
                 [&](std::size_t i) { read[i] = read_entry(now, waiting_[i]) ? 1 : 0; });
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      read[i] = read_entry(now, waiting_[i]) ? 1 : 0;
    }
  }
  // Those that have to wait come last, so that they do not keep others from being read.
  std::vector<Entry> left(waiting_.begin() + static_cast<std::ptrdiff_t>(count), waiting_.end());
  for (std::size_t i = 0; i < count; ++i) {
    if (read[i] == 0) {
      left.push_back(waiting_[i]);
    }
  }
  waiting_ = std::move(left);
  if (judge_.has_rechecks()) {
    judge_.recheck(most_rechecks);
  }
  stop_faulty_ranks();
  if (totals_.entries == before) {
    return false;
  }
  last_entry_ = last_life_ = now;
  return true;
}

/// Looks at the next entry of every block.
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

/// An entry that was lost on its way hides those behind it.
void WindowCollector::find_gaps(Time now) {
  for (Block& block : blocks_) {
    std::uint64_t end = block.end;
    while (end > block.next && load(layout_.log_word(end - 1)) == 0) {
      --end;
    }
    for (; block.next < end; ++block.next) {
      waiting_.push_back({block.next, now});
    }
  }
}

/// How many of the entries that wait have about so many cells.
std::size_t WindowCollector::entries_of(std::uint64_t most_cells) {
  std::uint64_t cells = 0;
  std::size_t count = 0;
  for (; count < waiting_.size() && cells < most_cells; ++count) {
    cells += range_from_word(load(layout_.log_word(waiting_[count].index))).count();
  }
  return count;
}

bool WindowCollector::wants_all_threads(Time now) const {
  return many_ranks_ && now - last_entry_ < quiet_time;
}

/// True when there is nothing more to expect of it. Any thread.
bool WindowCollector::read_entry(Time now, const Entry& entry) {
  const std::size_t first = layout_.log_word(entry.index);
  const std::uint64_t word = load(first);
  if (word == 0) {
    return false;
  }
  // A rank's number that has not arrived yet is 0 - 1.
  const std::uint64_t rank = load(first + 2) - 1;
  if (rank < layout_.ranks() &&
      take(static_cast<std::uint32_t>(rank), range_from_word(word), load(first + 1))) {
    return true;
  }
  if (now - entry.since < arrival_time) {
    return false;
  }
  const std::scoped_lock lock(mutex_);
  ++totals_.corrupt;  // its cells stay missing, so that somebody traces them again
  return true;
}

/// Whoever traces a cell once more writes to the same place, perhaps corrupt bytes, at any time: so
/// what is checked and merged is a copy.
bool WindowCollector::take(std::uint32_t rank, const CellRange& range, std::uint64_t digest) {
  if (range.begin >= range.end || range.end > plan_->cells()) {
    return false;
  }
  const auto there =
      memory_.subspan(layout_.record_offset(range.begin), range.count() * layout_.record_bytes());
  TracedCells traced;
  traced.range = range;
  traced.records.assign(there.begin(), there.end());
  std::vector<std::uint64_t> digests = cell_digests(traced.records, layout_.record_bytes());
  if (entry_digest(range_digest(digests), rank) != digest) {
    return false;
  }
  const std::vector<Cell> cells = plan_->grid()->cells_of(range);
  if (!complete(traced, cells)) {
    return false;
  }
  merge(rank, std::move(traced), std::move(digests), cells);
  return true;
}

/// Runs of the range's cells that are in.
std::vector<CellRange> WindowCollector::cells_in(const CellRange& range) const {
  std::vector<CellRange> in;
  for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
    if (!picture_.collector().has(cell)) {
      continue;
    }
    if (!in.empty() && in.back().end == cell) {
      ++in.back().end;
    } else {
      in.push_back({cell, cell + 1});
    }
  }
  return in;
}

/// Ranks that the judge has left out need not go on.
void WindowCollector::stop_faulty_ranks() {
  const std::vector<RankJudge::Verdict>& verdicts = judge_.verdicts();
  for (; verdicts_heeded_ < verdicts.size(); ++verdicts_heeded_) {
    for (const std::uint32_t rank : verdicts[verdicts_heeded_].left_out) {
      window_.store(WindowLayout::rank_word(rank, WindowLayout::stop), 1);
    }
  }
}

/// Of a faulty rank nothing is merged, and nothing at all for a plan that holds no more.
void WindowCollector::merge(std::uint32_t rank, TracedCells traced,
                            std::vector<std::uint64_t> digests, std::span<const Cell> cells) {
  const std::scoped_lock lock(mutex_);
  if (overtaken() || judge_.left_out(rank)) {
    return;
  }
  ResultCollector& collector = picture_.collector();
  if (const auto in = cells_in(traced.range); !in.empty()) {
    const std::vector<std::uint64_t> whole = collector.digests_of(traced);
    totals_.mismatches += collector.compare(traced.range, whole).mismatches;
    if (!judge_.admit(rank, traced, whole)) {
      return;
    }
    judge_.note_checks(rank, cells_in(traced.range));
  }
  for (std::uint64_t i = 0; i < cells.size(); ++i) {
    if (!collector.has(traced.range.begin + i)) {
      const auto record = std::span(traced.records).subspan(i * layout_.record_bytes());
      totals_.row_nanoseconds[cells[i].y] += header_of(record).nanoseconds;
    }
  }
  const TracerKey tracer = judge_.tracer(rank);
  const ResultCollector::Taken taken = picture_.take(tracer, traced, std::move(digests), cells);
  ++totals_.entries;
  totals_.duplicates += taken.duplicates;
  if (taken.fresh > 0 && hooks_.merged) {
    hooks_.merged(tracer, std::move(traced));
  }
}

/// Adds what does not travel through a window. False when the numbers are impossible ones.
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
  std::sort(traced.excluded.begin(), traced.excluded.end());
  return fault_of(traced, batch, cells, max_depth_of(picture_.settings())).empty();
}

double WindowCollector::progress() const {
  return static_cast<double>(picture_.collector().done_cells()) /
         static_cast<double>(picture_.plan()->cells());
}

void WindowCollector::finish() {
  for (std::uint32_t rank = 0; overtaken() && rank < layout_.ranks(); ++rank) {
    window_.store(WindowLayout::rank_word(rank, WindowLayout::stop), 1);
  }
  window_.store(Word::finished, 1);
}

void WindowCollector::issue_copies(Time now) {
  const std::uint64_t tickets = std::min(load(Word::tickets), layout_.most_copies());
  if (tickets > copies_issued_ && hungry_since_ == never) {
    find_gaps(now);
  }
  // What has not been read yet may be finished.
  if (tickets <= copies_issued_ || behind_ || overtaken() || picture_.collector().done()) {
    hungry_since_ = never;
    return;
  }
  hungry_since_ = std::min(hungry_since_, now);
  if (now - hungry_since_ < hunger_time || now < next_round_) {
    return;
  }
  const std::uint64_t left = picture_.plan()->cells() - picture_.collector().done_cells();
  const std::uint64_t most =
      std::clamp<std::uint64_t>(left / (2ULL * layout_.ranks()), 1, most_copy_cells);
  while (copies_issued_ < tickets) {
    if (copy_cursor_ == 0) {
      round_began_ = now;
    }
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
  return load(Word::step) + load(Word::position) + load(Word::tickets) + totals_.entries;
}

void WindowCollector::listen(Time now) {
  window_.fetch_add(Word::pulse, 1);
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
    if (at_work && now - life.changed >= patience) {
      silent.push_back(rank);
    }
  }
  return silent;
}

}  // namespace parray::coordinator
