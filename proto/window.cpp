#include "proto/window.h"

#include <xxhash.h>

#include <algorithm>
#include <atomic>

#include "common/base/divide_up.h"
#include "common/base/error.h"
#include "common/image/cell_records.h"

namespace parray::proto {
namespace {

std::uint64_t* word_at(std::span<std::byte> memory, std::size_t word) {
  return reinterpret_cast<std::uint64_t*>(memory.data()) + word;
}

}  // namespace

std::uint64_t LocalWindow::fetch_add(std::size_t word, std::uint64_t delta) {
  return std::atomic_ref(*word_at(memory_, word)).fetch_add(delta);
}
std::uint64_t LocalWindow::load(std::size_t word) {
  return std::atomic_ref(*word_at(memory_, word)).load();
}
void LocalWindow::store(std::size_t word, std::uint64_t value) {
  std::atomic_ref(*word_at(memory_, word)).store(value);
}
void LocalWindow::put(std::size_t offset, std::span<const std::byte> bytes) {
  std::ranges::copy(bytes, memory_.begin() + static_cast<std::ptrdiff_t>(offset));
}

using Operation = WindowRequest::Operation;

std::uint64_t perform(const WindowRequest& request, std::span<std::byte> memory,
                      const std::function<void(std::span<std::byte> bytes)>& receive) {
  const auto [operation, place, value] = request;
  const bool fits = operation == Operation::put
                        ? place <= memory.size() && value <= memory.size() - place
                        : place < memory.size() / sizeof(std::uint64_t);
  LocalWindow window(memory);
  if (fits) {
    switch (operation) {
      case Operation::fetch_add: return window.fetch_add(place, value);
      case Operation::load: return window.load(place);
      case Operation::store: window.store(place, value); return 0;
      case Operation::put: receive(memory.subspan(place, value)); return 0;
    }
  }
  throw RunError("a rank sent a request that reaches outside the window");
}

Ledgers::Ledgers(std::uint32_t ranks, std::uint32_t each)
    : ranks_(ranks), count_(static_cast<std::uint32_t>(divide_up(ranks, std::max(each, 1U)))) {}

std::uint32_t Ledgers::keeper(std::uint32_t ledger) const {
  const std::uint64_t end = std::uint64_t{ranks_} * (std::uint64_t{ledger} + 1) / count_;
  return count_ == 1 ? 0 : static_cast<std::uint32_t>(end - 1);
}

std::uint32_t Ledgers::home(std::uint32_t rank) const {
  auto ledger = static_cast<std::uint32_t>(std::uint64_t{rank} * count_ / ranks_);
  while (ledger + 1 < count_ && keeper(ledger) < rank) {
    ++ledger;  // corrects the rounding of the division
  }
  return ledger;
}

CellRange Ledgers::part(std::uint32_t ledger, std::uint64_t total) const {
  const auto begin = [&](std::uint64_t which) { return total * which / count_; };
  return {begin(ledger), begin(std::uint64_t{ledger} + 1)};
}

WindowLayout::WindowLayout(const CellGrid& grid, std::uint32_t ranks)
    : ranks_(ranks),
      cells_(grid.cells()),
      record_bytes_(image::record_bytes(grid.shape().cell_pixels)),
      log_blocks_(ranks + divide_up(cells_ + 4 * most_copies, block_entries)),
      first_copy_(shared_words + std::size_t{ranks} * rank_words),
      first_log_(first_copy_ + most_copies),
      first_record_((first_log_ + entry_words * log_blocks_ * block_entries) *
                    sizeof(std::uint64_t)),
      bytes_(first_record_ + cells_ * record_bytes_) {}

std::uint64_t entry_digest(std::uint64_t range_digest, std::uint32_t rank) {
  return XXH3_64bits_withSeed(&range_digest, sizeof range_digest, rank);
}

std::uint64_t to_word(const CellRange& range) { return range.begin << 24 | range.count(); }

CellRange range_from_word(std::uint64_t word) {
  const std::uint64_t begin = word >> 24;
  return {begin, begin + (word & most_cells_in_word)};
}

}  // namespace parray::proto
