#include "worker/window_source.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/source_rig.h"

namespace parray::test {
namespace {

using Rig = SourceRig;

}  // namespace

TEST_CASE("ranks in threads lease every cell exactly once, for all policies") {
  for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
    for (const std::uint32_t ranks : {1U, 2U, 3U, 8U}) {
      for (const std::uint32_t tile : {0U, 8U}) {
        CAPTURE(name_of(policy));
        CAPTURE(ranks);
        Rig rig(medium(), ranks, policy, 1 + ranks % 3, tile);
        std::vector<std::vector<CellRange>> taken(ranks);
        std::vector<std::thread> threads;
        for (std::uint32_t rank = 0; rank < ranks; ++rank) {
          threads.emplace_back([&, rank] {
            WindowSource leases = rig.rank(rank);
            taken[rank] = take_all(leases, 1e5 * (1 + rank));
          });
        }
        std::vector<CellRange> all;
        for (std::uint32_t rank = 0; rank < ranks; ++rank) {
          threads[rank].join();
          all.insert(all.end(), taken[rank].begin(), taken[rank].end());
        }
        CHECK(is_partition(all, rig.plan().cells()));
      }
    }
  }
}

TEST_CASE("ranks of several ledgers lease every cell exactly once, first from their own ledger") {
  for (const std::uint32_t ranks : {2U, 5U, 8U, 13U}) {
    for (const std::uint32_t each : {1U, 2U, 3U}) {
      CAPTURE(ranks);
      CAPTURE(each);
      Rig rig(medium(), ranks, weighted);
      rig.split(each);
      const Ledgers& ledgers = rig.ledgers->ledgers;
      std::vector<std::vector<CellRange>> taken(ranks);
      std::vector<std::thread> threads;
      for (std::uint32_t rank = 0; rank < ranks; ++rank) {
        threads.emplace_back([&, rank] {
          WindowSource leases = rig.rank(rank);
          taken[rank] = take_all(leases, 1e5 * (1 + rank));
        });
      }
      std::vector<CellRange> all;
      for (std::uint32_t rank = 0; rank < ranks; ++rank) {
        threads[rank].join();
        all.insert(all.end(), taken[rank].begin(), taken[rank].end());
      }
      CHECK(is_partition(all, rig.plan().cells()));
      CHECK(rig.window.load(Word::position) == 0);
      for (std::uint32_t ledger = 0; ledger < ledgers.count(); ++ledger) {
        CHECK(rig.kept[ledger]->load(Word::position) >=
              ledgers.part(ledger, rig.plan().cells()).count());
      }
      WindowSource late = rig.rank(0);
      CHECK(late.take_part(1e6, false).answer == Answer::wait);
    }
  }
}

TEST_CASE("a rank takes from its group's ledger first, and then from those of lost groups") {
  Rig rig(medium(), 6, weighted);
  rig.split(2);
  const auto part = rig.ledgers->ledgers.part(1, rig.plan().cells());
  WindowSource rank = rig.rank(2);
  const auto first = rank.take_part(0, false).cells;
  CHECK(first.begin == part.begin);
  std::vector<CellRange> all = take_all(rank, 1e6);
  all.push_back(first);
  CHECK(is_partition(all, rig.plan().cells()));  // no other rank took any
}

TEST_CASE("a ledger with fewer cells than ranks hands out each cell once") {
  Rig rig(made_settings(3, 2, 5), 12, weighted);
  rig.split(2);
  std::vector<CellRange> all;
  for (std::uint32_t number = 0; number < 12; ++number) {
    WindowSource rank = rig.rank(number);
    const auto parts = take_all(rank, 1e6);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  CHECK(is_partition(all, rig.plan().cells()));
}

TEST_CASE("a chunk computed from its step equals the one of a coordinator") {
  Dice dice(1);
  for (int i = 0; i < 200; ++i) {
    const auto settings =
        made_settings(1 + dice.below32(300), 1 + dice.below32(80), 1 + dice.below32(4000));
    for (const SchedulePolicy policy : {static_split, guided, factoring}) {
      CAPTURE(name_of(policy));
      Rig rig(settings, 1 + dice.below32(9), policy, 1 + dice.below32(4));
      std::vector<WindowSource> ranks;
      for (std::uint32_t rank = 0; rank < rig.layout.ranks(); ++rank) {
        ranks.push_back(rig.rank(rank));
      }
      ChunkRequest job = job_of(rig);
      std::uint64_t begin = 0;
      for (; job.remaining > 0; ++job.step) {
        const std::uint64_t units = chunk_units(policy, job);
        REQUIRE(take_lease(ranks[dice.below(ranks.size())], units) ==
                CellRange{begin, begin + units});
        begin += units;
        job.remaining -= units;
      }
      for (WindowSource& rank : ranks) REQUIRE(rank.take_part(0, false).answer == Answer::wait);
    }
  }
}

TEST_CASE("ranks with different numbers of threads compute the same chunks") {
  Rig rig(medium(), 2, guided);
  rig.options.all_threads = 10;
  rig.options.threads = 2;
  WindowSource small = rig.rank(0);
  rig.options.threads = 8;
  WindowSource large = rig.rank(1);
  std::vector<CellRange> all;
  for (int i = 0;; ++i) {
    const auto part = (i % 2 == 0 ? small : large).take_part(0, false);
    if (part.answer != Answer::lease) break;
    all.push_back(part.cells);
  }
  CHECK(is_partition(all, rig.plan().cells()));
}

TEST_CASE("a weighted lease is half of a rank's share of the remaining cells, by measured speed") {
  Rig rig(made_settings(400, 400, 2000), 2, weighted);
  WindowSource slow = rig.rank(0, 0, 1e9);
  WindowSource fast = rig.rank(1, 0, 1e9);
  weighted_cells(rig, slow, 1e6);
  auto left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, fast, 3e6) == std::ceil(left * 0.75 / 2));
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, slow, 1e6) == std::ceil(left * 0.25 / 2));
  // The sum follows falling and rising speeds.
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, fast, 1e6) == std::ceil(left * 0.5 / 2));
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, slow, 4e6) == std::ceil(left * 0.8 / 2));
}

TEST_CASE("a weighted lease has a length within the given bounds") {
  Rig rig(made_settings(400, 400, 2000), 2, weighted);
  const double cell = rig.plan().cell_samples();
  WindowSource rank = rig.rank(0, 0.01, 0.5);
  CHECK(weighted_cells(rig, rank, 1e7) == std::floor(5e6 / cell));
  WindowSource last = rig.rank(1, 0.01, 0.5);
  rig.window.store(Word::position, rig.plan().cells() - 200);
  CHECK(weighted_cells(rig, last, 1e7) == std::floor(1e5 / cell));
}

TEST_CASE("the first lease is small, but has work for every thread") {
  for (const std::uint32_t threads : {1U, 2U, 64U}) {
    Rig rig(made_settings(400, 400, 2000), 4, weighted, threads);
    const double cell = rig.plan().cell_samples();
    WindowSource rank = rig.rank(0);
    const double cells = weighted_cells(rig, rank, 0);
    CHECK(cells >= threads);
    CHECK(cells * cell <= 1e5 * threads);
  }
}

TEST_CASE("ranks slower than the unit of speed take leases of a sensible length") {
  Rig rig(made_settings(400, 400, 2000), 4, weighted);
  WindowSource slow = rig.rank(0);
  WindowSource fresh = rig.rank(1);
  weighted_cells(rig, slow, 0);
  CHECK(weighted_cells(rig, slow, 200) == 1);
  CHECK(SpeedSum::from_word(rig.window.load(Word::speed)).kilosamples > 0);
  CHECK(weighted_cells(rig, fresh, 0) * rig.plan().cell_samples() <= 1e5);
}

TEST_CASE("only idle ranks get copies, one for each ticket") {
  Rig rig(medium(), 2, static_split);
  WindowSource rank = rig.rank(1);
  WindowSource other = rig.rank(0);
  take_all(rank, 1e6);
  take_all(other, 1e6);
  for (int i = 0; i < 3; ++i) CHECK(rank.take_part(1e6, false).answer == Answer::wait);
  CHECK(rig.window.load(Word::copy_requests) == 0);
  for (int i = 0; i < 3; ++i) {
    CHECK(rank.take_part(1e6, true).answer == Answer::wait);
    CHECK(other.take_part(1e6, true).answer == Answer::wait);
  }
  CHECK(rig.window.load(Word::copy_requests) == 2);  // drawn once each
  rig.window.store(rig.layout.copy_word(0), to_word({3, 5}));
  rig.window.store(Word::copies, 1);
  CHECK(other.take_part(1e6, true).answer == Answer::wait);
  const auto copy = rank.take_part(1e6, true);
  REQUIRE(copy.answer == Answer::lease);
  CHECK(copy.cells == CellRange{3, 5});
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);  // a request is answered once
  CHECK(rig.window.load(Word::copy_requests) == 3);
  rig.window.store(rig.layout.copy_word(1), to_word({7, 9}));
  rig.window.store(rig.layout.copy_word(2), to_word({9, 10}));
  rig.window.store(Word::copies, 3);
  CHECK(rank.take_part(1e6, true).cells == CellRange{9, 10});
  CHECK(other.take_part(1e6, true).cells == CellRange{7, 9});
}

TEST_CASE("ranks end when rank 0 sets finished, and wait if there is no place for a copy") {
  Rig rig(medium(), 2, weighted);
  WindowSource rank = rig.rank(1);
  rig.window.store(Word::position, rig.plan().cells());
  rig.window.store(Word::copy_requests, WindowLayout::most_copies);
  rig.window.store(Word::copies, WindowLayout::most_copies);
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);
  rig.window.store(Word::finished, 1);
  CHECK(rank.take_part(1e6, false).answer == Answer::wait);
  CHECK(rank.take_part(1e6, true).answer == Answer::over);
}

}  // namespace parray::test
