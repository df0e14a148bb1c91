#include "proto/window.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::WindowMemory;

/// [begin, end) of bytes.
using Region = std::pair<std::size_t, std::size_t>;

Region words(std::size_t first, std::size_t count) {
  return {first * sizeof(std::uint64_t), (first + count) * sizeof(std::uint64_t)};
}

std::vector<Region> regions_of(const WindowLayout& layout) {
  std::vector<Region> regions = {words(0, WindowLayout::shared_words)};
  for (std::uint32_t rank = 0; rank < layout.ranks(); ++rank) {
    for (std::size_t word = 0; word < WindowLayout::rank_words; ++word) {
      regions.push_back(
          words(WindowLayout::rank_word(rank, static_cast<WindowLayout::RankWord>(word)), 1));
    }
  }
  for (std::uint64_t copy = 0; copy < WindowLayout::most_copies; ++copy) {
    regions.push_back(words(layout.copy_word(copy), 1));
  }
  for (std::uint64_t entry = 0; entry < layout.log_blocks() * WindowLayout::block_entries;
       ++entry) {
    regions.push_back(words(layout.log_word(entry), WindowLayout::entry_words));
  }
  for (std::uint64_t cell = 0; cell < layout.cells(); ++cell) {
    const std::size_t offset = layout.record_offset(cell);
    regions.emplace_back(offset, offset + layout.record_bytes());
  }
  return regions;
}

void check_operations(Window& window, WindowMemory& memory) {
  CHECK(window.fetch_add(3, 5) == 0);
  CHECK(window.fetch_add(3, 7) == 5);
  CHECK(window.load(3) == 12);
  CHECK(window.fetch_add(3, std::uint64_t{0} - 13) == 12);
  CHECK(window.load(3) == UINT64_MAX);
  window.store(4, 99);
  CHECK(window.fetch_add(4, 1) == 99);
  const std::array<std::uint64_t, 2> value = {77, 78};
  window.put(40, std::as_bytes(std::span(value)));
  CHECK(window.load(4) == 100);
  CHECK(window.load(5) == 77);
  CHECK(window.load(6) == 78);
  CHECK(window.load(7) == 0);
  CHECK(LocalWindow(memory.bytes()).load(3) == UINT64_MAX);  // another view of the same memory
}

}  // namespace

TEST_CASE("windows add, load and store words, and put bytes at their offset") {
  WindowMemory memory(64);
  SUBCASE("in the memory of this process") {
    LocalWindow window(memory.bytes());
    check_operations(window, memory);
  }
  SUBCASE("by requests to the owner") {
    RequestWindow window = test::request_window(memory.bytes());
    check_operations(window, memory);
  }
}

TEST_CASE("a request outside a window's memory is refused and changes nothing") {
  using Operation = WindowRequest::Operation;
  WindowMemory memory(64);
  const std::vector<WindowRequest> requests = {
      {Operation::fetch_add, 8, 1},    {Operation::load, UINT64_MAX, 0},
      {Operation::store, 1U << 31, 1}, {Operation::put, 64, 1},
      {Operation::put, 0, 65},         {Operation::put, 8, UINT64_MAX},
      {Operation::put, UINT64_MAX, 8}, {static_cast<Operation>(4), 0, 1}};
  for (const WindowRequest& request : requests) {
    CAPTURE(request.place);
    CHECK_THROWS_AS(
        perform(request, memory.bytes(), [](std::span<std::byte>) { FAIL("received"); }), RunError);
  }
  for (std::size_t word = 0; word < 8; ++word) CHECK(LocalWindow(memory.bytes()).load(word) == 0);
  CHECK(perform({Operation::put, 64, 0}, memory.bytes(),
                [](std::span<std::byte> bytes) { CHECK(bytes.empty()); }) == 0);
}

TEST_CASE("additions of many threads to a local window are atomic") {
  WindowMemory memory(8);
  LocalWindow window(memory.bytes());
  constexpr std::uint64_t each = 20'000;
  std::vector<std::vector<std::uint64_t>> drawn(4);
  std::vector<std::thread> threads;
  for (auto& mine : drawn) {
    threads.emplace_back([&] {
      for (std::uint64_t i = 0; i < each; ++i) mine.push_back(window.fetch_add(0, 1));
    });
  }
  std::set<std::uint64_t> all;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    threads[i].join();
    CHECK(std::is_sorted(drawn[i].begin(), drawn[i].end()));
    all.insert(drawn[i].begin(), drawn[i].end());
  }
  CHECK(all.size() == each * drawn.size());
  CHECK(window.load(0) == each * drawn.size());
}

TEST_CASE("the regions of a window do not overlap and fill it") {
  Dice dice(1);
  for (int i = 0; i < 5; ++i) {
    const auto plan = test::whole_plan(
        test::made_settings(1 + dice.below32(3000), 1 + dice.below32(9), 1 + dice.below32(5000)));
    const WindowLayout layout(*plan->grid(), 1 + dice.below32(70));
    auto regions = regions_of(layout);
    std::sort(regions.begin(), regions.end());
    std::size_t end = 0;
    bool good = true;
    for (const Region& region : regions) {
      good = good && region.first == end && region.first % 8 == 0 && region.second > end;
      end = region.second;
    }
    CHECK(good);
    CHECK(end == layout.bytes());
    CHECK(layout.zeroed_bytes() == layout.record_offset(0));
    CHECK(layout.record_bytes() == record_bytes(plan->grid()->shape().cell_pixels));
    CHECK(layout.cells() == plan->cells());
    const std::uint64_t shared = layout.log_blocks() - layout.ranks();
    CHECK(shared * WindowLayout::block_entries >= plan->cells() + WindowLayout::most_copies);
  }
}

TEST_CASE("every rank and every cell has one ledger, and groups have equal sizes") {
  Dice dice(5);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t ranks = 1 + dice.below32(i % 2 == 0 ? 20 : 5000);
    const std::uint32_t each = 1 + dice.below32(ranks + 5);
    CAPTURE(ranks);
    CAPTURE(each);
    const Ledgers ledgers(ranks, each);
    std::vector<std::uint32_t> groups(ledgers.count());
    for (std::uint32_t rank = 0; rank < ranks; ++rank) {
      REQUIRE(ledgers.home(rank) < ledgers.count());
      ++groups[ledgers.home(rank)];
    }
    CHECK(*std::ranges::max_element(groups) <= each);
    CHECK(*std::ranges::max_element(groups) - *std::ranges::min_element(groups) <= 1);
    const std::uint64_t total = dice.below(std::uint64_t{1} << 40);
    std::uint64_t end = 0;
    for (std::uint32_t ledger = 0; ledger < ledgers.count(); ++ledger) {
      CHECK(ledgers.is_keeper(ledgers.keeper(ledger)));
      CHECK(ledgers.part(ledger, total).begin == end);
      end = ledgers.part(ledger, total).end;
    }
    CHECK(end == total);
  }
  CHECK(Ledgers(7, 7).keeper(0) == 0);
  CHECK(Ledgers(256).count() == 1);
  CHECK(Ledgers(257).count() == 2);
}

TEST_CASE("a range of cells is equal after packing into a word, and no range is packed as 0") {
  Dice dice(2);
  for (int i = 0; i < 10'000; ++i) {
    const std::uint64_t begin = dice.below(std::uint64_t{1} << 40);
    const std::uint64_t count = 1 + dice.below(most_cells_in_word);
    const CellRange range{begin, begin + count};
    CHECK_UNARY(to_word(range) != 0);
    CHECK_UNARY(range_from_word(to_word(range)) == range);
  }
  const CellRange last{(std::uint64_t{1} << 40) - 1, (std::uint64_t{1} << 40) + (1U << 24) - 2};
  CHECK(range_from_word(to_word(last)) == last);
  CHECK(range_from_word(0).count() == 0);
}

TEST_CASE("the word of speeds is the sum of the latest speeds, rising or falling") {
  Dice dice(4);
  constexpr std::size_t ranks = 50;
  std::array<SpeedSum, ranks> latest{};
  std::uint64_t word = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::size_t rank = dice.below(ranks);
    const SpeedSum next = {dice.one_in(5) ? 0 : 1 + dice.below(256), dice.below(10'000'000)};
    word += next.word() - latest[rank].word();
    latest[rank] = next;
    SpeedSum sum;
    for (const SpeedSum& speed : latest) {
      sum.threads += speed.threads;
      sum.kilosamples += speed.kilosamples;
    }
    REQUIRE(SpeedSum::from_word(word).threads == sum.threads);
    REQUIRE(SpeedSum::from_word(word).kilosamples == sum.kilosamples);
  }
}

TEST_CASE("the word of speeds has room for a million threads of ten million samples per second") {
  const SpeedSum sum{1'000'000, 10'000'000'000};
  CHECK(SpeedSum::from_word(sum.word()).threads == sum.threads);
  CHECK(SpeedSum::from_word(sum.word()).kilosamples == sum.kilosamples);
}

}  // namespace parray
