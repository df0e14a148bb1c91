#include "worker/window_leases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::WindowMemory;
using enum SchedulePolicy;
using Answer = LeaseSource::Answer;
using Word = WindowLayout::Word;

/// The window of a job and the leases of its ranks, all of as many threads.
struct Rig {
  Rig(const RenderSettings& settings, std::uint32_t ranks, SchedulePolicy policy,
      std::uint32_t threads = 1, std::uint32_t tile = 0)
      : plan(settings, {{0, settings.height, 0, settings.samples_per_pixel}}, tile),
        layout(plan, ranks),
        memory(layout.bytes()),
        window(memory.bytes()) {
    options.policy = policy;
    options.threads = threads;
    options.all_threads = threads * ranks;
  }
  WindowLeases rank(std::uint32_t number) {
    WindowLeaseOptions own = options;
    own.rank = number;
    return {plan, layout, window, own};
  }
  WindowLeases rank(std::uint32_t number, double shortest, double longest) {
    options.shortest_seconds = shortest;
    options.longest_seconds = longest;
    return rank(number);
  }

  WorkPlan plan;
  WindowLayout layout;
  WindowMemory memory;
  LocalWindow window;
  WindowLeaseOptions options;
};

RenderSettings medium() { return test::made_settings(60, 40, 700); }

/// True if the ranges are the plan's cells, each once.
bool is_partition(std::vector<CellRange> ranges, std::uint64_t cells) {
  std::sort(ranges.begin(), ranges.end(),
            [](const CellRange& a, const CellRange& b) { return a.begin < b.begin; });
  std::uint64_t end = 0;
  for (const CellRange& range : ranges) {
    if (range.begin != end || range.end <= range.begin) {
      return false;
    }
    end = range.end;
  }
  return end == cells;
}

/// Takes until there is nothing left, telling `speed` after the first lease.
std::vector<CellRange> take_all(WindowLeases& leases, double speed) {
  std::vector<CellRange> ranges;
  for (auto taken = leases.take(0, false); taken.answer == Answer::lease;
       taken = leases.take(speed, false)) {
    ranges.push_back(taken.range);
  }
  return ranges;
}

/// Looks, whenever a word is stored, whether bytes have been put already.
class OrderWindow final : public Window {
 public:
  explicit OrderWindow(Window& window) : window_(window) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return window_.fetch_add(word, delta);
  }
  std::uint64_t load(std::size_t word) override { return window_.load(word); }
  void store(std::size_t word, std::uint64_t value) override {
    CHECK(put_);
    stored.push_back(word);
    window_.store(word, value);
  }
  void put(std::size_t offset, std::span<const std::byte> bytes) override {
    put_ = true;
    window_.put(offset, bytes);
  }
  std::vector<std::size_t> stored;

 private:
  Window& window_;
  bool put_ = false;
};

ChunkRequest job_of(const Rig& rig) {
  ChunkRequest job;
  job.total = rig.plan.cells();
  job.remaining = job.total;
  job.row_units = rig.plan.cells_per_row();
  job.workers = rig.layout.ranks();
  job.threads = rig.options.threads;
  return job;
}

}  // namespace

TEST_CASE("ranks in threads of their own lease every cell exactly once, whatever the policy") {
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
            WindowLeases leases = rig.rank(rank);
            taken[rank] = take_all(leases, 1e5 * (1 + rank));
          });
        }
        std::vector<CellRange> all;
        for (std::uint32_t rank = 0; rank < ranks; ++rank) {
          threads[rank].join();
          all.insert(all.end(), taken[rank].begin(), taken[rank].end());
        }
        CHECK(is_partition(all, rig.plan.cells()));
      }
    }
  }
}

TEST_CASE("a chunk computed from its step is the one that a coordinator would have handed out") {
  Dice dice(1);
  for (int i = 0; i < 200; ++i) {
    const auto settings =
        test::made_settings(1 + dice.below32(300), 1 + dice.below32(80), 1 + dice.below32(4000));
    for (const SchedulePolicy policy : {static_split, guided, factoring}) {
      CAPTURE(name_of(policy));
      Rig rig(settings, 1 + dice.below32(9), policy, 1 + dice.below32(4));
      std::vector<WindowLeases> ranks;
      for (std::uint32_t rank = 0; rank < rig.layout.ranks(); ++rank) {
        ranks.push_back(rig.rank(rank));
      }
      ChunkRequest job = job_of(rig);
      std::uint64_t begin = 0;
      for (; job.remaining > 0; ++job.step) {
        const std::uint64_t units = chunk_units(policy, job);
        const auto taken = ranks[dice.below(ranks.size())].take(0, true);
        REQUIRE(taken.answer == Answer::lease);
        REQUIRE(taken.range == CellRange{begin, begin + units});
        begin += units;
        job.remaining -= units;
      }
      for (WindowLeases& rank : ranks) {
        REQUIRE(rank.take(0, false).answer == Answer::wait);
      }
    }
  }
}

TEST_CASE("all ranks compute the same chunks although their numbers of threads differ") {
  Rig rig(medium(), 2, guided);
  rig.options.all_threads = 10;
  rig.options.threads = 2;
  WindowLeases small = rig.rank(0);
  rig.options.threads = 8;
  WindowLeases large = rig.rank(1);
  std::vector<CellRange> all;
  for (int i = 0;; ++i) {
    const auto taken = (i % 2 == 0 ? small : large).take(0, false);
    if (taken.answer != Answer::lease) {
      break;
    }
    all.push_back(taken.range);
  }
  CHECK(is_partition(all, rig.plan.cells()));
}

TEST_CASE("weighted leases are half of a rank's share of what is left, by measured speed") {
  Rig rig(test::made_settings(400, 400, 2000), 2, weighted);
  WindowLeases slow = rig.rank(0, 0, 1e9);
  WindowLeases fast = rig.rank(1, 0, 1e9);
  slow.take(1e6, false);
  auto left = static_cast<double>(rig.plan.cells() - rig.window.load(Word::position));
  CHECK(static_cast<double>(fast.take(3e6, false).range.count()) == std::ceil(left * 0.75 / 2));
  left = static_cast<double>(rig.plan.cells() - rig.window.load(Word::position));
  CHECK(static_cast<double>(slow.take(1e6, false).range.count()) == std::ceil(left * 0.25 / 2));
  // The sum follows a speed that falls, and one that rises.
  left = static_cast<double>(rig.plan.cells() - rig.window.load(Word::position));
  CHECK(static_cast<double>(fast.take(1e6, false).range.count()) == std::ceil(left * 0.5 / 2));
  left = static_cast<double>(rig.plan.cells() - rig.window.load(Word::position));
  CHECK(static_cast<double>(slow.take(4e6, false).range.count()) == std::ceil(left * 0.8 / 2));
}

TEST_CASE("a weighted lease is neither shorter nor longer than asked for") {
  Rig rig(test::made_settings(400, 400, 2000), 2, weighted);
  const double cell = rig.plan.cell_samples();
  WindowLeases rank = rig.rank(0, 0.01, 0.5);
  CHECK(rank.take(1e7, false).range.count() == static_cast<std::uint64_t>(5e6 / cell));
  WindowLeases last = rig.rank(1, 0.01, 0.5);
  rig.window.store(Word::position, rig.plan.cells() - 200);
  CHECK(last.take(1e7, false).range.count() == static_cast<std::uint64_t>(1e5 / cell));
}

TEST_CASE("a first lease only measures: a small one that has work for every thread") {
  for (const std::uint32_t threads : {1U, 2U, 64U}) {
    Rig rig(test::made_settings(400, 400, 2000), 4, weighted, threads);
    const double cell = rig.plan.cell_samples();
    const auto taken = rig.rank(0).take(0, true);
    REQUIRE(taken.answer == Answer::lease);
    CHECK(taken.range.count() >= threads);
    CHECK(static_cast<double>(taken.range.count()) * cell <= 1e5 * threads);
  }
}

TEST_CASE("ranks slower than the unit of speeds neither take everything nor nothing") {
  Rig rig(test::made_settings(400, 400, 2000), 4, weighted);
  WindowLeases slow = rig.rank(0);
  WindowLeases fresh = rig.rank(1);
  slow.take(0, true);
  CHECK(slow.take(200, true).range.count() == 1);
  CHECK(SpeedSum::from_word(rig.window.load(Word::speed)).kilosamples > 0);
  const auto taken = fresh.take(0, true);
  REQUIRE(taken.answer == Answer::lease);
  CHECK(static_cast<double>(taken.range.count()) * rig.plan.cell_samples() <= 1e5);
}

TEST_CASE("copies are for the idle alone, one for each ticket") {
  Rig rig(medium(), 2, static_split);
  WindowLeases rank = rig.rank(1);
  WindowLeases other = rig.rank(0);
  CHECK(rank.take(0, true).answer == Answer::lease);
  CHECK(other.take(0, true).answer == Answer::lease);
  for (int i = 0; i < 3; ++i) {
    CHECK(rank.take(1e6, false).answer == Answer::wait);
  }
  CHECK(rig.window.load(Word::tickets) == 0);
  for (int i = 0; i < 3; ++i) {
    CHECK(rank.take(1e6, true).answer == Answer::wait);
    CHECK(other.take(1e6, true).answer == Answer::wait);
  }
  CHECK(rig.window.load(Word::tickets) == 2);  // drawn once each
  rig.window.store(rig.layout.copy_word(0), to_word({3, 5}));
  rig.window.store(Word::copies, 1);
  CHECK(other.take(1e6, true).answer == Answer::wait);
  const auto copy = rank.take(1e6, true);
  REQUIRE(copy.answer == Answer::lease);
  CHECK(copy.range == CellRange{3, 5});
  CHECK(rank.take(1e6, true).answer == Answer::wait);  // a ticket is answered once
  CHECK(rig.window.load(Word::tickets) == 3);
  rig.window.store(rig.layout.copy_word(1), to_word({7, 9}));
  rig.window.store(rig.layout.copy_word(2), to_word({9, 10}));
  rig.window.store(Word::copies, 3);
  CHECK(rank.take(1e6, true).range == CellRange{9, 10});
  CHECK(other.take(1e6, true).range == CellRange{7, 9});
}

TEST_CASE(
    "nothing is left once the coordinator says so, and without a place for a copy ranks wait") {
  Rig rig(medium(), 2, weighted);
  WindowLeases rank = rig.rank(1);
  rig.window.store(Word::position, rig.plan.cells());
  rig.window.store(Word::tickets, rig.layout.most_copies());
  rig.window.store(Word::copies, rig.layout.most_copies());
  CHECK(rank.take(1e6, true).answer == Answer::wait);
  CHECK(rank.take(1e6, true).answer == Answer::wait);
  rig.window.store(Word::finished, 1);
  CHECK(rank.take(1e6, false).answer == Answer::wait);
  CHECK(rank.take(1e6, true).answer == Answer::over);
}

TEST_CASE("a completed range is in its place and in the log, with its digest") {
  Rig rig(medium(), 2, weighted);
  WindowLeases rank = rig.rank(1);
  const CellRange range{4, 9};
  const auto records = test::made_records(rig.plan, range);
  rank.complete({0, 1}, test::made_records(rig.plan, {0, 1}));
  rank.complete(range, records);
  const std::size_t offset = rig.layout.record_offset(4);
  CHECK(std::equal(records.begin(), records.end(),
                   rig.memory.bytes().begin() + static_cast<std::ptrdiff_t>(offset)));
  CHECK(rig.window.load(Word::log_head) == 2);
  CHECK(rig.window.load(rig.layout.log_word(1)) == to_word(range));
  CHECK(rig.window.load(rig.layout.log_word(1) + 1) ==
        range_digest(cell_digests(records, rig.layout.record_bytes())));
  rank.tell(WindowLayout::takes, 17);
  CHECK(rig.window.load(WindowLayout::rank_word(1, WindowLayout::takes)) == 17);
}

TEST_CASE("bytes are put before the entry that speaks of them, and its range makes it valid") {
  Rig rig(medium(), 2, weighted);
  OrderWindow window(rig.window);
  WindowLeases rank(rig.plan, rig.layout, window, rig.options);
  rank.complete({4, 9}, test::made_records(rig.plan, {4, 9}));
  const std::size_t entry = rig.layout.log_word(0);
  CHECK(window.stored == std::vector<std::size_t>{entry + 1, entry});
}

TEST_CASE("a full log is left alone") {
  Rig rig(test::made_settings(8, 2, 3), 1, weighted);
  WindowLeases rank = rig.rank(0);
  rig.window.store(Word::log_head, rig.layout.most_log_entries());
  const auto before = std::vector(rig.memory.bytes().begin(), rig.memory.bytes().end());
  rank.log({0, 1}, 5);
  rig.window.store(Word::log_head, rig.layout.most_log_entries());
  CHECK(std::equal(before.begin(), before.end(), rig.memory.bytes().begin()));
}

}  // namespace parray
