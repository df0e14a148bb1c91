#include "coordinator/window_collector.h"

#include <algorithm>
#include <atomic>

namespace parray {
namespace {

using Word = WindowLayout::Word;

/// Bytes on their way may arrive after the entry that speaks of them; longer than any network
/// takes.
constexpr Time arrival_time = seconds(2);

/// Ranks end within a few milliseconds of each other anyway.
constexpr Time hunger_time = milliseconds(5);

/// A copy is one entry of the log, so it is small; what is left is cut into enough of them.
constexpr std::uint64_t most_copy_cells = 1024;

}  // namespace

TracerKey rank_tracer() { return tracer_key("parray-mpi", ""); }

WindowCollector::WindowCollector(JobPicture& picture, const WindowLayout& layout, Window& window,
                                 std::span<const std::byte> memory, Time now, Totals& totals,
                                 Hooks hooks)
    : picture_(picture),
      layout_(layout),
      window_(window),
      memory_(memory),
      totals_(totals),
      hooks_(std::move(hooks)),
      lives_(layout.ranks(), Life{0, now}),
      last_life_(now) {
  totals_.row_nanoseconds.resize(picture.settings().height);
}

/// Words are not const for atomic_ref, but nothing is written.
std::uint64_t WindowCollector::load(std::size_t word) const {
  auto* const words =
      const_cast<std::uint64_t*>(reinterpret_cast<const std::uint64_t*>(memory_.data()));
  return std::atomic_ref(words[word]).load();
}

bool WindowCollector::collect(Time now, std::uint64_t most_cells) {
  const std::uint64_t claimed = std::min(load(Word::log_head), layout_.most_log_entries());
  for (; next_entry_ < claimed; ++next_entry_) {
    waiting_.push_back({next_entry_, now});
  }
  const ResultCollector& collector = picture_.collector();
  const std::uint64_t before = totals_.entries;
  const std::uint64_t enough = collector.done_cells() + most_cells;
  std::erase_if(waiting_, [&](const Entry& entry) {
    return collector.done_cells() < enough && read_entry(now, entry);
  });
  behind_ = collector.done_cells() >= enough;
  if (totals_.entries == before) {
    return false;
  }
  last_life_ = now;
  return true;
}

/// True when there is nothing more to expect of it.
bool WindowCollector::read_entry(Time now, const Entry& entry) {
  const std::uint64_t word = load(layout_.log_word(entry.index));
  if (word == 0) {
    return false;
  }
  if (take(range_from_word(word), load(layout_.log_word(entry.index) + 1))) {
    ++totals_.entries;
    return true;
  }
  if (now - entry.since < arrival_time) {
    return false;
  }
  ++totals_.corrupt;  // its cells stay missing, so that somebody traces them again
  return true;
}

/// Whoever traces a cell once more writes to the same place, perhaps corrupt bytes, at any time: so
/// what is checked and merged is a copy.
bool WindowCollector::take(const CellRange& range, std::uint64_t digest) {
  if (range.begin >= range.end || range.end > picture_.plan()->cells()) {
    return false;
  }
  const auto there =
      memory_.subspan(layout_.record_offset(range.begin), range.count() * layout_.record_bytes());
  TracedCells traced;
  traced.range = range;
  traced.records.assign(there.begin(), there.end());
  if (range_digest(cell_digests(traced.records, layout_.record_bytes())) != digest ||
      !complete(traced, picture_.plan()->batch(range))) {
    return false;
  }
  for (std::uint64_t i = 0; i < range.count(); ++i) {
    if (!picture_.collector().has(range.begin + i)) {
      const auto record = std::span(traced.records).subspan(i * layout_.record_bytes());
      totals_.row_nanoseconds[picture_.plan()->cell(range.begin + i).y] +=
          header_of(record).nanoseconds;
    }
  }
  const ResultCollector::Taken taken = picture_.take(rank_tracer(), traced);
  totals_.duplicates += taken.duplicates;
  totals_.mismatches += taken.mismatches;
  if (taken.fresh > 0 && hooks_.merged) {
    hooks_.merged(std::move(traced));
  }
  return true;
}

/// Adds what does not travel through a window. False when the numbers are impossible ones.
bool WindowCollector::complete(TracedCells& traced, const CellBatch& batch) const {
  traced.samples = batch.sample_count();
  for (std::uint64_t i = 0; i < traced.range.count(); ++i) {
    const auto record = std::span(traced.records).subspan(i * layout_.record_bytes());
    if (header_of(record).nonfinite > 0 && hooks_.locate) {
      const std::uint64_t cell = traced.range.begin + i;
      const auto found = hooks_.locate(picture_.plan()->batch({cell, cell + 1}));
      traced.excluded.insert(traced.excluded.end(), found.begin(), found.end());
    }
  }
  std::sort(traced.excluded.begin(), traced.excluded.end());
  return fault_of(traced, batch, picture_.settings().max_depth).empty();
}

double WindowCollector::progress() const {
  return static_cast<double>(picture_.collector().done_cells()) /
         static_cast<double>(picture_.plan()->cells());
}

void WindowCollector::issue_copies(Time now) {
  const std::uint64_t tickets = std::min(load(Word::tickets), layout_.most_copies());
  // What has not been read yet may be finished.
  if (tickets <= copies_issued_ || behind_ || done()) {
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
  return load(Word::step) + load(Word::position) + load(Word::tickets) + load(Word::log_head);
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

}  // namespace parray
