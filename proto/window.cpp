#include "proto/window.h"

#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cstring>

namespace parray {
namespace {

std::uint64_t* word_at(std::span<std::byte> memory, std::size_t word) {
  return reinterpret_cast<std::uint64_t*>(memory.data()) + word;
}

/// Only idle ranks get copies: many times as many as there can be ranks, and still small.
constexpr std::uint64_t copy_slots = 1U << 16;

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
  std::memcpy(memory_.data() + offset, bytes.data(), bytes.size());
}

WindowLayout::WindowLayout(const WorkPlan& plan, std::uint32_t ranks)
    : ranks_(ranks),
      cells_(plan.cells()),
      record_bytes_(record_bytes_of(plan)),
      most_copies_(copy_slots),
      most_log_entries_(plan.cells() + 4 * copy_slots),
      first_copy_(shared_words + std::size_t{ranks} * rank_words),
      first_log_(first_copy_ + most_copies_),
      first_record_((first_log_ + 2 * most_log_entries_) * sizeof(std::uint64_t)),
      bytes_(first_record_ + plan.cells() * record_bytes_) {}

std::uint64_t to_word(const CellRange& range) { return range.begin << 24 | range.count(); }

CellRange range_from_word(std::uint64_t word) {
  const std::uint64_t begin = word >> 24;
  return {begin, begin + (word & most_cells_in_word)};
}

std::uint64_t cell_digest(std::span<const std::byte> record) {
  constexpr std::size_t time = offsetof(CellHeader, nanoseconds);
  const std::uint64_t counts = XXH3_64bits(record.data(), time);
  const auto sums = record.subspan(sizeof(CellHeader));
  return std::max<std::uint64_t>(XXH3_64bits_withSeed(sums.data(), sums.size(), counts), 1);
}

std::vector<std::uint64_t> cell_digests(std::span<const std::byte> records,
                                        std::size_t record_bytes) {
  std::vector<std::uint64_t> digests;
  digests.reserve(records.size() / record_bytes);
  for (; !records.empty(); records = records.subspan(record_bytes)) {
    digests.push_back(cell_digest(records.first(record_bytes)));
  }
  return digests;
}

std::uint64_t range_digest(std::span<const std::uint64_t> cell_digests) {
  return XXH3_64bits(cell_digests.data(), cell_digests.size_bytes());
}

}  // namespace parray
