#include "coordinator/window_ledger.h"

#include <algorithm>
#include <cstring>

namespace parray {
namespace {

using Word = WindowLayout::Word;

/// Bytes on their way may arrive after the entry that speaks of them; longer than any network
/// takes.
constexpr Time arrival_time = seconds(2);

/// Ranks end within a few milliseconds of each other anyway.
constexpr Time hunger_time = milliseconds(5);

constexpr std::size_t most_block_bytes = std::size_t{1} << 25;

/// A copy is one entry of the log, so it is small; what is left is cut into enough of them.
constexpr std::uint64_t most_copy_cells = 1024;

}  // namespace

WindowLedger::WindowLedger(const WorkPlan& plan, const WindowLayout& layout, Window& window,
                           std::span<std::byte> memory, Framebuffer& framebuffer, Time now,
                           Locate locate)
    : plan_(plan),
      layout_(layout),
      window_(window),
      memory_(memory),
      view_(memory),
      framebuffer_(framebuffer),
      locate_(std::move(locate)),
      digests_(plan.cells()),
      cells_left_(plan.passes(), plan.cells_per_row()),
      row_nanoseconds_(framebuffer.height()),
      lives_(layout.ranks(), Life{0, now}),
      last_life_(now) {}

void WindowLedger::go_on_from(const WindowLedger& before) {
  tally_.entries += before.tally_.entries;
  tally_.duplicates += before.tally_.duplicates;
  tally_.mismatches += before.tally_.mismatches;
  tally_.corrupt += before.tally_.corrupt;
  tally_.copies += before.tally_.copies;
  for (std::size_t row = 0; row < row_nanoseconds_.size(); ++row) {
    row_nanoseconds_[row] += before.row_nanoseconds_[row];
  }
}

bool WindowLedger::collect(Time now, std::uint64_t most_cells) {
  const std::uint64_t claimed = std::min(view_.load(Word::log_head), layout_.most_log_entries());
  for (; next_entry_ < claimed; ++next_entry_) {
    waiting_.push_back({next_entry_, now});
  }
  const std::uint64_t before = tally_.entries;
  const std::uint64_t enough = done_cells_ + most_cells;
  std::erase_if(waiting_, [&](const Entry& entry) {
    return done_cells_ < enough && read_entry(now, entry) != Reading::not_yet;
  });
  behind_ = done_cells_ >= enough;
  if (tally_.entries == before) {
    return false;
  }
  last_life_ = now;
  return true;
}

WindowLedger::Reading WindowLedger::read_entry(Time now, const Entry& entry) {
  const std::uint64_t word = view_.load(layout_.log_word(entry.index));
  if (word == 0) {
    return Reading::not_yet;
  }
  const CellRange range = range_from_word(word);
  const bool possible = range.begin < range.end && range.end <= plan_.cells();
  std::vector<std::uint64_t> digests;
  if (possible) {
    digests = cell_digests(
        memory_.subspan(layout_.record_offset(range.begin), range.count() * layout_.record_bytes()),
        layout_.record_bytes());
  }
  if (!possible || range_digest(digests) != view_.load(layout_.log_word(entry.index) + 1)) {
    if (now - entry.since < arrival_time) {
      return Reading::not_yet;
    }
    ++tally_.corrupt;  // its cells stay unfinished, so that somebody traces them again
    return Reading::corrupt;
  }
  ++tally_.entries;
  for (std::uint64_t i = 0; i < digests.size(); ++i) {
    take_cell(range.begin + i, digests[i]);
  }
  return Reading::taken;
}

void WindowLedger::take_cell(std::uint64_t cell, std::uint64_t digest) {
  if (digests_[cell] != 0) {
    ++(digests_[cell] == digest ? tally_.duplicates : tally_.mismatches);
    return;
  }
  digests_[cell] = digest;
  ++done_cells_;
  const std::uint64_t pass = plan_.pass_of(cell);
  if (--cells_left_[pass] == 0) {
    merge_pass(pass);
  }
}

void WindowLedger::merge_pass(std::uint64_t pass) {
  Row row = row_of(pass);
  if (!row.spoilt.empty()) {
    ++tally_.corrupt;
    done_cells_ -= row.spoilt.size();
    cells_left_[pass] = row.spoilt.size();
    for (const std::uint64_t cell : row.spoilt) {
      digests_[cell] = 0;  // unfinished, so that somebody traces it again
    }
    return;
  }
  row_nanoseconds_[row.block.rect.row_begin] += row.nanoseconds;
  framebuffer_.merge(row.block);
  fresh_passes_.insert(pass);
  ++merged_passes_;
}

/// Whoever traces a cell once more writes to the same place, perhaps corrupt bytes, at any time: so
/// what is used is a copy that still has the digest that was taken in.
WindowLedger::Row WindowLedger::row_of(std::uint64_t pass) const {
  const WorkPlan::Stride cells = plan_.pass_cells(pass);
  Row row{{plan_.pass_rect(pass), framebuffer_.width(), {}, {}}, 0, {}};
  RowBlock& block = row.block;
  block.pixels.resize(block.width);
  std::vector<std::byte> record(layout_.record_bytes());
  for (std::uint64_t i = 0; i < plan_.cells_per_row(); ++i) {
    const std::uint64_t index = cells.first + i * cells.step;
    std::memcpy(record.data(), memory_.data() + layout_.record_offset(index), record.size());
    if (cell_digest(record) != digests_[index]) {
      row.spoilt.push_back(index);
      continue;
    }
    const Cell cell = plan_.cell(index);
    CellHeader header;
    std::memcpy(&header, record.data(), sizeof header);
    block.counts.samples += cell.samples();
    block.counts.rays += header.rays;
    block.counts.nonfinite += header.nonfinite;
    block.counts.lost += header.lost;
    if (header.nonfinite > 0) {
      const auto found = locate_(cell);
      block.excluded.insert(block.excluded.end(), found.begin(), found.end());
    }
    row.nanoseconds += header.nanoseconds;
    std::memcpy(block.pixels.data() + cell.x_begin, record.data() + sizeof header,
                cell.pixels() * sizeof(PixelSums));
  }
  return row;
}

std::optional<RowBlock> WindowLedger::take_finished_rows() {
  const std::size_t row_bytes = framebuffer_.width() * sizeof(PixelSums);
  std::optional<RowBlock> block;
  while (!fresh_passes_.empty()) {
    const std::uint64_t pass = *fresh_passes_.begin();
    const WorkRect next = plan_.pass_rect(pass);
    if (block &&
        (next.row_begin != block->rect.row_end || next.sample_begin != block->rect.sample_begin ||
         next.sample_end != block->rect.sample_end ||
         (block->rect.rows() + 1) * row_bytes > most_block_bytes)) {
      break;
    }
    fresh_passes_.erase(pass);
    Row row = row_of(pass);
    if (!row.spoilt.empty()) {
      ++rows_left_out_;
      continue;  // it is in the picture; only a later life would have to trace it again
    }
    if (!block) {
      block = std::move(row.block);
      continue;
    }
    block->rect.row_end = next.row_end;
    block->counts += row.block.counts;
    block->excluded.insert(block->excluded.end(), row.block.excluded.begin(),
                           row.block.excluded.end());
    block->pixels.insert(block->pixels.end(), row.block.pixels.begin(), row.block.pixels.end());
  }
  return block;
}

double WindowLedger::progress() const {
  return plan_.cells() == 0 ? 1
                            : static_cast<double>(done_cells_) / static_cast<double>(plan_.cells());
}

double WindowLedger::complete_rows() const {
  return plan_.passes() == 0
             ? 1
             : static_cast<double>(merged_passes_) / static_cast<double>(plan_.passes());
}

CellRange WindowLedger::next_unfinished(std::uint64_t from, std::uint64_t most) const {
  while (from < digests_.size() && digests_[from] != 0) {
    ++from;
  }
  CellRange range{from, from};
  while (range.end < digests_.size() && digests_[range.end] == 0 && range.count() < most) {
    ++range.end;
  }
  return range;
}

void WindowLedger::issue_copies(Time now) {
  const std::uint64_t tickets = std::min(view_.load(Word::tickets), layout_.most_copies());
  // What this ledger has not read yet may be finished.
  if (tickets <= copies_issued_ || behind_ || done()) {
    hungry_since_ = never;
    return;
  }
  hungry_since_ = std::min(hungry_since_, now);
  if (now - hungry_since_ < hunger_time || now < next_round_) {
    return;
  }
  const std::uint64_t left = plan_.cells() - done_cells_;
  const std::uint64_t most =
      std::clamp<std::uint64_t>(left / (2ULL * layout_.ranks()), 1, most_copy_cells);
  while (copies_issued_ < tickets) {
    if (copy_cursor_ == 0) {
      round_began_ = now;
    }
    const CellRange range = next_unfinished(copy_cursor_, most);
    if (range.count() == 0) {  // the round is over
      copy_cursor_ = 0;
      next_round_ = now + std::max(2 * (now - round_began_), Time(milliseconds(50)));
      break;
    }
    copy_cursor_ = range.end;
    window_.store(layout_.copy_word(copies_issued_), to_word(range));
    ++copies_issued_;
    ++tally_.copies;
  }
  window_.store(Word::copies, copies_issued_);
}

std::uint64_t WindowLedger::activity() {
  return view_.load(Word::step) + view_.load(Word::position) + view_.load(Word::tickets) +
         view_.load(Word::log_head);
}

void WindowLedger::listen(Time now) {
  window_.fetch_add(Word::pulse, 1);
  for (std::uint32_t rank = 0; rank < layout_.ranks(); ++rank) {
    const std::uint64_t beat = rank_value(rank, WindowLayout::beat);
    if (beat != lives_[rank].beat) {
      lives_[rank] = {beat, now};
      last_life_ = now;
    }
  }
}

std::vector<std::uint32_t> WindowLedger::silent_ranks(Time now, Time patience) const {
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

std::uint64_t WindowLedger::rank_value(std::uint32_t rank, WindowLayout::RankWord word) {
  return view_.load(WindowLayout::rank_word(rank, word));
}

}  // namespace parray
