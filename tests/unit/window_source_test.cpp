#include "worker/window_source.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using enum SchedulePolicy;
using Answer = LeaseSource::Answer;
using Word = WindowLayout::Word;

/// The window of a job and the leases of its ranks, all of as many threads.
struct Rig : test::WindowRig {
  Rig(const RenderSettings& its_settings, std::uint32_t ranks, SchedulePolicy policy,
      std::uint32_t threads = 1, std::uint32_t tile = 0, const std::vector<CellRange>& done = {})
      : WindowRig(its_settings, ranks, tile, done) {
    options.policy = policy;
    options.threads = threads;
    options.all_threads = threads * ranks;
  }
  WindowSource rank(std::uint32_t number) {
    WindowOptions own = options;
    own.rank = number;
    return {job, pass, layout, window, own, ledgers};
  }
  /// With several ledgers, each in memory of its own.
  void split(std::uint32_t ledger_ranks) {
    ledgers.emplace(LedgerWindows{Ledgers(layout.ranks(), ledger_ranks), {}});
    for (std::uint32_t ledger = 0; ledger < ledgers->ledgers.count(); ++ledger) {
      ledger_memory.emplace_back(WindowLayout::shared_words * sizeof(std::uint64_t));
      kept.push_back(std::make_unique<LocalWindow>(ledger_memory.back().bytes()));
      ledgers->windows.push_back(kept.back().get());
    }
  }
  WindowSource rank(std::uint32_t number, double shortest, double longest) {
    options.length = {shortest, longest};
    return rank(number);
  }
  [[nodiscard]] std::uint64_t left() { return plan().cells() - window.load(Word::position); }

  WindowOptions options;
  std::optional<LedgerWindows> ledgers;
  std::deque<test::WindowMemory> ledger_memory;
  std::vector<std::unique_ptr<LocalWindow>> kept;
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
std::vector<CellRange> take_all(WindowSource& source, double speed) {
  std::vector<CellRange> parts;
  for (auto part = source.take_part(0, false); part.answer == Answer::lease;
       part = source.take_part(speed, false)) {
    parts.push_back(part.cells);
  }
  return parts;
}

/// The rank's next lease, of so many cells: parts without a gap, of which the first alone is fresh.
CellRange take_lease(WindowSource& source, std::uint64_t cells, double speed = 0) {
  CellRange lease;
  for (bool fresh = true; lease.count() < cells; fresh = false) {
    const auto part = source.take_part(speed, false);
    REQUIRE(part.answer == Answer::lease);
    REQUIRE(part.fresh == fresh);
    REQUIRE((fresh || part.cells.begin == lease.end));
    lease = {fresh ? part.cells.begin : lease.begin, part.cells.end};
  }
  return lease;
}

/// How many cells the rank's next weighted lease has.
double weighted_cells(Rig& rig, WindowSource& source, double speed) {
  const std::uint64_t before = rig.window.load(Word::position);
  const CellRange first = source.take_part(speed, false).cells;
  const std::uint64_t count = rig.window.load(Word::position) - before;
  for (std::uint64_t taken = first.count(); taken < count;) {
    const auto part = source.take_part(speed, false);
    REQUIRE_FALSE(part.fresh);
    taken += part.cells.count();
  }
  return static_cast<double>(count);
}

/// Where bytes have been put, in that order.
class OrderWindow final : public Window {
 public:
  explicit OrderWindow(Window& window) : window_(window) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return window_.fetch_add(word, delta);
  }
  std::uint64_t load(std::size_t word) override { return window_.load(word); }
  void store(std::size_t word, std::uint64_t value) override { window_.store(word, value); }
  void put(std::size_t offset, std::span<const std::byte> bytes) override {
    offsets.push_back(offset);
    window_.put(offset, bytes);
  }
  std::vector<std::size_t> offsets;

 private:
  Window& window_;
};

ChunkRequest job_of(const Rig& rig) {
  ChunkRequest job;
  job.total = rig.pass.missing.count();
  job.remaining = job.total;
  job.row_units = rig.plan().grid()->cells_per_row();
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

TEST_CASE("ranks of several ledgers lease every cell exactly once, each from its own at first") {
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

TEST_CASE(
    "a rank takes from its group's ledger first, and cells of a group that is gone go to others") {
  Rig rig(medium(), 6, weighted);
  rig.split(2);
  const auto part = rig.ledgers->ledgers.part(1, rig.plan().cells());
  WindowSource rank = rig.rank(2);
  const auto first = rank.take_part(0, false).cells;
  CHECK(first.begin == part.begin);
  std::vector<CellRange> all = take_all(rank, 1e6);
  all.push_back(first);
  CHECK(is_partition(all, rig.plan().cells()));  // nobody else ever came
}

TEST_CASE("a ledger of fewer cells than ranks gives each once") {
  Rig rig(test::made_settings(3, 2, 5), 12, weighted);
  rig.split(2);
  std::vector<CellRange> all;
  for (std::uint32_t number = 0; number < 12; ++number) {
    WindowSource rank = rig.rank(number);
    const auto parts = take_all(rank, 1e6);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  CHECK(is_partition(all, rig.plan().cells()));
}

TEST_CASE("a chunk computed from its step is the one that a coordinator would have handed out") {
  Dice dice(1);
  for (int i = 0; i < 200; ++i) {
    const auto settings =
        test::made_settings(1 + dice.below32(300), 1 + dice.below32(80), 1 + dice.below32(4000));
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
      for (WindowSource& rank : ranks) {
        REQUIRE(rank.take_part(0, false).answer == Answer::wait);
      }
    }
  }
}

TEST_CASE("all ranks compute the same chunks although their numbers of threads differ") {
  Rig rig(medium(), 2, guided);
  rig.options.all_threads = 10;
  rig.options.threads = 2;
  WindowSource small = rig.rank(0);
  rig.options.threads = 8;
  WindowSource large = rig.rank(1);
  std::vector<CellRange> all;
  for (int i = 0;; ++i) {
    const auto part = (i % 2 == 0 ? small : large).take_part(0, false);
    if (part.answer != Answer::lease) {
      break;
    }
    all.push_back(part.cells);
  }
  CHECK(is_partition(all, rig.plan().cells()));
}

TEST_CASE("weighted leases are half of a rank's share of what is left, by measured speed") {
  Rig rig(test::made_settings(400, 400, 2000), 2, weighted);
  WindowSource slow = rig.rank(0, 0, 1e9);
  WindowSource fast = rig.rank(1, 0, 1e9);
  weighted_cells(rig, slow, 1e6);
  auto left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, fast, 3e6) == std::ceil(left * 0.75 / 2));
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, slow, 1e6) == std::ceil(left * 0.25 / 2));
  // The sum follows a speed that falls, and one that rises.
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, fast, 1e6) == std::ceil(left * 0.5 / 2));
  left = static_cast<double>(rig.left());
  CHECK(weighted_cells(rig, slow, 4e6) == std::ceil(left * 0.8 / 2));
}

TEST_CASE("a weighted lease is neither shorter nor longer than asked for") {
  Rig rig(test::made_settings(400, 400, 2000), 2, weighted);
  const double cell = rig.plan().cell_samples();
  WindowSource rank = rig.rank(0, 0.01, 0.5);
  CHECK(weighted_cells(rig, rank, 1e7) == std::floor(5e6 / cell));
  WindowSource last = rig.rank(1, 0.01, 0.5);
  rig.window.store(Word::position, rig.plan().cells() - 200);
  CHECK(weighted_cells(rig, last, 1e7) == std::floor(1e5 / cell));
}

TEST_CASE("a first lease only measures: a small one that has work for every thread") {
  for (const std::uint32_t threads : {1U, 2U, 64U}) {
    Rig rig(test::made_settings(400, 400, 2000), 4, weighted, threads);
    const double cell = rig.plan().cell_samples();
    WindowSource rank = rig.rank(0);
    const double cells = weighted_cells(rig, rank, 0);
    CHECK(cells >= threads);
    CHECK(cells * cell <= 1e5 * threads);
  }
}

TEST_CASE("ranks slower than the unit of speeds neither take everything nor nothing") {
  Rig rig(test::made_settings(400, 400, 2000), 4, weighted);
  WindowSource slow = rig.rank(0);
  WindowSource fresh = rig.rank(1);
  weighted_cells(rig, slow, 0);
  CHECK(weighted_cells(rig, slow, 200) == 1);
  CHECK(SpeedSum::from_word(rig.window.load(Word::speed)).kilosamples > 0);
  CHECK(weighted_cells(rig, fresh, 0) * rig.plan().cell_samples() <= 1e5);
}

TEST_CASE("copies are for the idle alone, one for each ticket") {
  Rig rig(medium(), 2, static_split);
  WindowSource rank = rig.rank(1);
  WindowSource other = rig.rank(0);
  take_all(rank, 1e6);
  take_all(other, 1e6);
  for (int i = 0; i < 3; ++i) {
    CHECK(rank.take_part(1e6, false).answer == Answer::wait);
  }
  CHECK(rig.window.load(Word::tickets) == 0);
  for (int i = 0; i < 3; ++i) {
    CHECK(rank.take_part(1e6, true).answer == Answer::wait);
    CHECK(other.take_part(1e6, true).answer == Answer::wait);
  }
  CHECK(rig.window.load(Word::tickets) == 2);  // drawn once each
  rig.window.store(rig.layout.copy_word(0), to_word({3, 5}));
  rig.window.store(Word::copies, 1);
  CHECK(other.take_part(1e6, true).answer == Answer::wait);
  const auto copy = rank.take_part(1e6, true);
  REQUIRE(copy.answer == Answer::lease);
  CHECK(copy.cells == CellRange{3, 5});
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);  // a ticket is answered once
  CHECK(rig.window.load(Word::tickets) == 3);
  rig.window.store(rig.layout.copy_word(1), to_word({7, 9}));
  rig.window.store(rig.layout.copy_word(2), to_word({9, 10}));
  rig.window.store(Word::copies, 3);
  CHECK(rank.take_part(1e6, true).cells == CellRange{9, 10});
  CHECK(other.take_part(1e6, true).cells == CellRange{7, 9});
}

TEST_CASE(
    "nothing is left once the coordinator says so, and without a place for a copy ranks wait") {
  Rig rig(medium(), 2, weighted);
  WindowSource rank = rig.rank(1);
  rig.window.store(Word::position, rig.plan().cells());
  rig.window.store(Word::tickets, rig.layout.most_copies());
  rig.window.store(Word::copies, rig.layout.most_copies());
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);
  CHECK(rank.take_part(1e6, true).answer == Answer::wait);
  rig.window.store(Word::finished, 1);
  CHECK(rank.take_part(1e6, false).answer == Answer::wait);
  CHECK(rank.take_part(1e6, true).answer == Answer::over);
}

TEST_CASE("a result is in its place and in the log, with its digest and its rank") {
  Rig rig(medium(), 2, weighted);
  WindowSource rank = rig.rank(1);
  const CellRange range{4, 9};
  const auto records = test::made_records(rig.plan(), range);
  rank.put({0, 1}, test::made_records(rig.plan(), {0, 1}));
  rank.put(range, records);
  const std::size_t offset = rig.layout.record_offset(4);
  CHECK(std::equal(records.begin(), records.end(),
                   rig.memory.bytes().begin() + static_cast<std::ptrdiff_t>(offset)));
  CHECK(rig.window.load(Word::log_head) == 0);  // the first block is the rank's own
  const std::size_t entry = rig.layout.log_word(WindowLayout::block_entries + 1);
  CHECK(rig.window.load(entry) == to_word(range));
  CHECK(rig.window.load(entry + 1) ==
        entry_digest(range_digest(cell_digests(records, rig.layout.record_bytes())), 1));
  CHECK(rig.window.load(entry + 2) == 2);
  rank.publish(WindowLayout::takes, 17);
  CHECK(rig.window.load(WindowLayout::rank_word(1, WindowLayout::takes)) == 17);
}

TEST_CASE("bytes are put before the entry that speaks of them") {
  Rig rig(medium(), 2, weighted);
  OrderWindow window(rig.window);
  WindowSource rank(rig.job, rig.pass, rig.layout, window, rig.options);
  rank.put({4, 9}, test::made_records(rig.plan(), {4, 9}));
  CHECK(window.offsets ==
        std::vector<std::size_t>{rig.layout.record_offset(4), 8 * rig.layout.log_word(0)});
}

TEST_CASE("a rank that has filled its block of the log claims another, and nobody else's") {
  Rig rig(test::made_settings(60, 4, 2000), 2, weighted);
  WindowSource first = rig.rank(0);
  WindowSource second = rig.rank(1);
  REQUIRE(rig.plan().cells() > 5 * WindowLayout::block_entries);
  for (std::uint64_t cell = 0; cell < rig.plan().cells(); ++cell) {
    WindowSource& rank = cell % 3 == 0 ? first : second;
    rank.put({cell, cell + 1}, test::made_records(rig.plan(), {cell, cell + 1}));
  }
  rig.collect();
  CHECK(rig.collector.done());
  CHECK(rig.totals.duplicates == 0);
}

TEST_CASE("a full log is left alone") {
  Rig rig(test::made_settings(8, 2, 3), 1, weighted);
  WindowSource rank = rig.rank(0);
  for (std::uint64_t entry = 0; entry < WindowLayout::block_entries; ++entry) {
    rank.log({0, 1}, 5);
  }
  rig.window.store(Word::log_head, rig.layout.log_blocks());
  const auto before = std::vector(rig.memory.bytes().begin(), rig.memory.bytes().end());
  rank.log({0, 1}, 5);
  rig.window.store(Word::log_head, rig.layout.log_blocks());
  CHECK(std::equal(before.begin(), before.end(), rig.memory.bytes().begin()));
}

TEST_CASE("a long lease comes in parts of half a second, without a gap or an overlap") {
  Rig rig(test::made_settings(1000, 1000, 500), 2, static_split);
  WindowSource rank = rig.rank(0);
  const std::uint64_t half = rig.plan().cells() / 2;
  std::uint64_t end = 0;
  for (int i = 0; end < half; ++i) {
    const auto part = rank.take_part(i == 0 ? 0 : 1e7, false);
    REQUIRE(part.answer == Answer::lease);
    CHECK(part.cells.begin == end);
    // The first lease is cut before any speed is known.
    CHECK(static_cast<double>(part.cells.count()) * rig.plan().cell_samples() <= 1e6);
    end = part.cells.end;
  }
  CHECK(end == half);
  CHECK(rank.take_part(1e7, false).fresh);  // the other half
}

TEST_CASE("no part is larger than a result may be") {
  Rig rig(test::made_settings(8192, 1000, 1), 1, static_split);
  WindowSource rank = rig.rank(0);
  for (auto part = rank.take_part(1e15, false); part.answer == Answer::lease;
       part = rank.take_part(1e15, false)) {
    CHECK(part.cells.count() * rig.layout.record_bytes() <= std::size_t{1} << 25);
  }
}

TEST_CASE("of a pass that an earlier life has begun, ranks lease the missing cells only") {
  Dice dice(7);
  for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
    for (int i = 0; i < 10; ++i) {
      CAPTURE(name_of(policy));
      const std::uint64_t cells = test::whole_plan(medium())->cells();
      std::vector<CellRange> done;
      for (std::uint64_t cell = dice.below(20); cell + 20 < cells; cell += 1 + dice.below(90)) {
        done.push_back({cell, cell + 1 + dice.below(19)});
        cell = done.back().end;
      }
      Rig rig(medium(), 2, policy, 1, 0, done);
      std::vector<CellRange> all = done;
      WindowSource first = rig.rank(0);
      WindowSource second = rig.rank(1);
      for (bool found = true; found;) {
        found = false;
        for (WindowSource* rank : {&first, &second}) {
          const auto part = rank->take_part(1e6, false);
          if (part.answer == Answer::lease) {
            found = true;
            all.push_back(part.cells);
            rank->put(part.cells, test::made_records(rig.plan(), part.cells));
          }
        }
      }
      CHECK(is_partition(all, rig.plan().cells()));
      rig.collect();
      CHECK(rig.totals.duplicates == 0);
      CHECK(test::same_sums(rig.picture.framebuffer(), test::made_framebuffer(rig.settings)));
    }
  }
}

TEST_CASE("a lease has what tracing it takes, and the scene goes once it is with the team") {
  Rig rig(medium(), 1, weighted);
  rig.job.scene = std::make_shared<const Scene>(test::small_scene());
  WindowSource source = rig.rank(0);
  auto first = source.take(Time(0), 0, true);
  auto second = source.take(Time(0), 0, true);
  CHECK(first.lease.scene == rig.job.scene);
  CHECK(first.lease.scene_id == "made up");
  CHECK(first.lease.settings == rig.settings);
  CHECK_FALSE(first.lease.key() == second.lease.key());
  CHECK(source.wants(first.lease.key()));
  CHECK(first.samples ==
        static_cast<double>(first.lease.cells.range.count()) * rig.plan().cell_samples());
  Finished finished;
  finished.cells = std::make_shared<const TracedCells>(test::made_cells(first.lease.cells));
  source.complete(Time(0), finished);
  CHECK_FALSE(rig.job.scene);
  rig.collect();
  CHECK(rig.picture.collector().done_cells() == first.lease.cells.range.count());
  finished.cells.reset();
  finished.failure = "not enough memory";
  CHECK_THROWS_WITH_AS(source.complete(Time(0), finished), "tracing: not enough memory", RunError);
}

TEST_CASE("a rank's beat counts its samples and says what its team does, four times a second") {
  Rig rig(medium(), 2, weighted);
  WindowSource source = rig.rank(1);
  const auto beat = [&] { return rig.window.load(WindowLayout::rank_word(1, WindowLayout::beat)); };
  CHECK(source.tick(seconds(1), {77, true, false}) == milliseconds(1250));
  CHECK(beat() == (77 | beat_flags::tracing));
  source.tick(milliseconds(1249), {99, true, false});
  CHECK(beat() == (77 | beat_flags::tracing));
  source.tick(milliseconds(1250), {99, true, true});
  CHECK(beat() == (99 | beat_flags::tracing | beat_flags::building));
  source.tick(milliseconds(1500), {99, false, false});
  CHECK(beat() == 99);
}

TEST_CASE("a report holds what the rank has done") {
  Rig rig(medium(), 2, weighted);
  rig.rank(1).report({6000, 2, Time(2000), Time(4000), 6e-3, 0.5, 1234, "avx2"});
  const auto value = [&](WindowLayout::RankWord word) {
    return rig.window.load(WindowLayout::rank_word(1, word));
  };
  CHECK(value(WindowLayout::samples) == 6000);
  CHECK(value(WindowLayout::takes) == 2);
  CHECK(value(WindowLayout::taking) == 2000);
  CHECK(value(WindowLayout::putting) == 4000);
  CHECK(value(WindowLayout::busy) == 6'000'000);
  CHECK(value(WindowLayout::build) == 500'000'000);
  CHECK(value(WindowLayout::tree_bytes) == 1234);
}

}  // namespace parray
