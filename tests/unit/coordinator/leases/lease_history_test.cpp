#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/leases/lease_table.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

/// Compares random histories of a lease table with a model that has a state for every cell.
namespace parray {
namespace {

using test::Dice;
using Arrival = LeaseTable::Arrival;

/// How often each event happened in all histories. An event that never happens is not tested.
struct HistoryTally {
  int grants = 0;
  int copies = 0;
  int checks = 0;
  int refusals = 0;
  std::map<Arrival, int> arrivals;
  int parts = 0;
  int late_parts = 0;
  int no_good = 0;
  int expired = 0;
  int dropped = 0;
  int extended = 0;
  int put_back = 0;
  int orphans = 0;
};

/// The state of one lease as PROTOCOL.md describes it.
struct Record {
  CellRange range;
  std::map<WorkerId, Time> holders;
  WorkerId arrived = 0;  ///< the worker whose result is being merged
  std::set<WorkerId> late{};
  bool check = false;
  MachineKey by = 0;
  std::set<MachineKey> not_by{};
  bool over = false;
};

class History {
 public:
  History(std::uint64_t seed, HistoryTally& tally)
      : dice_(seed),
        tally_(tally),
        cells_(1 + dice_.below(60), State::pending),
        most_(dice_.one_in(2) ? UINT64_MAX : 1 + dice_.below(9)),
        table_(sizer(), {{0, cells_.size()}}, 1, most_) {}

  void run() {
    for (std::uint64_t step = dice_.below(150); step > 0; --step) {
      this->step();
      check_invariants();
    }
    finish();
  }

 private:
  enum class State : std::uint8_t { pending, leased, done };

  ChunkSizer sizer() {
    RenderSettings settings;
    settings.width = 10;
    settings.height = static_cast<std::uint32_t>(cells_.size());
    settings.samples_per_pixel = 4;
    settings.schedule = static_cast<SchedulePolicy>(dice_.below(4));
    settings.row_order = RowOrder::sequential;
    return {settings.schedule, WorkPlan(settings, {{{0, 4}}, {}}), {}};
  }

  void step() {
    switch (dice_.below(20)) {
      case 0:
      case 1:
      case 2:
      case 3:
      case 4: return grant(some_worker());
      case 5:
      case 6: return copy(some_worker());
      case 7:
      case 8:
      case 9:
      case 10: return result();
      case 11:
      case 12:
      case 13: return merged();
      case 14: return pass_time();
      case 15: return lose_worker(some_worker());
      case 16:
      case 17: return heartbeat();
      case 18: return want_check();
      default: return put_back();
    }
  }

  WorkerId some_worker() { return 1 + dice_.below(5); }
  Time some_deadline() {
    return now_ + milliseconds(1 + static_cast<std::int64_t>(dice_.below(100)));
  }

  bool move(const CellRange& range, State from, State to) {
    bool good = true;
    for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
      good = good && cells_.at(cell) == from;
      cells_[cell] = to;
    }
    return good;
  }
  [[nodiscard]] std::uint64_t count(State state) const {
    return static_cast<std::uint64_t>(std::count(cells_.begin(), cells_.end(), state));
  }

  void grant(WorkerId worker) {
    const Time deadline = some_deadline();
    const auto check = std::ranges::find(checks_, worker, &Record::by);
    const auto lease = table_.grant(deadline, worker, {1 + dice_.below32(3), 0},
                                    {0, 0, 1 + dice_.below32(9), 1 + dice_.below32(4)}, worker);
    if (check == checks_.end() && count(State::pending) == 0) {
      ++tally_.refusals;
      REQUIRE_FALSE(lease);
      return;
    }
    REQUIRE(lease);
    REQUIRE(lease->epoch == ++last_epoch_);  // never used before
    Record record;
    if (check != checks_.end()) {
      ++tally_.checks;
      record = *check;
      REQUIRE(lease->range == record.range);
      checks_.erase(check);
    } else {
      ++tally_.grants;
      record.range = lease->range;
      REQUIRE(lease->range.count() >= 1);
      REQUIRE(lease->range.count() <= most_);
      REQUIRE(move(lease->range, State::pending, State::leased));
    }
    record.holders[worker] = deadline;
    records_[lease->epoch] = record;
  }

  void copy(WorkerId worker) {
    const auto oldest = std::find_if(records_.begin(), records_.end(), [worker](const auto& entry) {
      const Record& r = entry.second;
      return !r.over && !r.check && r.arrived == 0 && !r.holders.contains(worker) &&
             r.holders.size() < LeaseTable::most_holders;
    });
    const Time deadline = some_deadline();
    const auto lease = table_.grant_copy(deadline, worker);
    REQUIRE(lease.has_value() == (oldest != records_.end()));
    if (lease) {
      ++tally_.copies;
      REQUIRE(lease->epoch == oldest->first);
      REQUIRE(lease->range == oldest->second.range);
      oldest->second.holders[worker] = deadline;
    }
  }

  /// A result of a holder, or of any worker for a past, current or future lease.
  void result() {
    WorkerId worker = some_worker();
    Epoch epoch = dice_.below(last_epoch_ + 2);
    if (dice_.one_in(2)) {
      for (const auto& [held, r] : records_) {
        if (!r.holders.empty() && dice_.one_in(3)) {
          epoch = held;
          worker = r.holders.begin()->first;
        }
      }
    }
    const auto found = records_.find(epoch);
    const std::uint64_t cells = dice_.one_in(2) ? 0 : dice_.below(4);
    Arrival expected = Arrival::stale;
    std::set<WorkerId> dropped;
    if (found != records_.end()) {
      Record& r = found->second;
      const bool part = cells > 0 && cells < r.range.count();
      const bool late = r.late.erase(worker) > 0;
      if (late || (!r.over && r.holders.erase(worker) > 0)) {
        if (late || r.arrived != 0) {
          expected = part ? Arrival::stale : Arrival::again;
          tally_.late_parts += part ? 1 : 0;
        } else {
          expected = r.check ? Arrival::check : Arrival::first;
          r.arrived = worker;
          dropped = part && !r.check ? shorten(r, cells) : dropped;
        }
      }
    }
    const auto arrived = table_.arrive(worker, epoch, cells);
    ++tally_.arrivals[arrived.kind];
    REQUIRE(arrived.kind == expected);
    REQUIRE(std::set<WorkerId>(arrived.dropped.begin(), arrived.dropped.end()) == dropped);
    if (expected != Arrival::stale) REQUIRE(arrived.range == found->second.range);
  }

  /// Returns the workers that held a copy.
  std::set<WorkerId> shorten(Record& r, std::uint64_t cells) {
    ++tally_.parts;
    const CellRange rest{r.range.begin + cells, r.range.end};
    r.range.end = rest.begin;
    REQUIRE(move(rest, State::leased, State::pending));
    std::set<WorkerId> others;
    for (const auto& [holder, deadline] : r.holders) others.insert(holder);
    r.holders.clear();
    return others;
  }

  /// Merges an arrived result, or discards it as invalid.
  void merged() {
    for (auto& [epoch, r] : records_) {
      if (r.over || r.arrived == 0 || dice_.one_in(3)) continue;
      const WorkerId worker = std::exchange(r.arrived, 0);
      if (dice_.one_in(4)) {
        ++tally_.no_good;
        REQUIRE_FALSE(table_.give_back(worker, epoch));
        table_.reject(epoch);
        retire_if_unheld(r, false);
        continue;
      }
      std::set<WorkerId> others;
      for (const auto& [holder, deadline] : r.holders) others.insert(holder);
      const auto named = table_.finish(epoch);
      REQUIRE(std::set<WorkerId>(named.begin(), named.end()) == others);
      REQUIRE(move(r.range, r.check ? State::done : State::leased, State::done));
      if (r.check) losses_.erase(r.by);
      r.late = others;
      r.holders.clear();
      r.over = true;
    }
  }

  void retire_if_unheld(Record& r, bool lost) {
    if (r.over || r.arrived != 0 || !r.holders.empty()) return;
    r.over = true;
    if (r.check) {
      Record failed{r.range, {}, 0, {}, true, r.by, r.not_by};
      if (!lost || ++losses_[r.by] >= LeaseTable::most_losses) failed.not_by.insert(r.by);
      failed_.push_back(failed);
    } else {
      REQUIRE(move(r.range, State::leased, State::pending));
    }
  }

  void pass_time() {
    now_ += milliseconds(static_cast<std::int64_t>(dice_.below(60)));
    std::set<std::pair<Epoch, WorkerId>> expected;
    std::vector<std::pair<Time, Epoch>> order;  // in which expired leases become pending
    for (auto& [epoch, r] : records_) {
      for (const auto& [holder, deadline] : r.holders) {
        if (deadline <= now_) {
          expected.emplace(epoch, holder);
          order.emplace_back(deadline, epoch);
        }
      }
      std::erase_if(r.holders, [&](const auto& holder) { return holder.second <= now_; });
    }
    std::sort(order.begin(), order.end());
    for (const auto& [deadline, epoch] : order) retire_if_unheld(records_.at(epoch), true);
    std::set<std::pair<Epoch, WorkerId>> expired;
    for (const auto& gone : table_.expire(now_)) expired.emplace(gone.lease.epoch, gone.worker);
    tally_.expired += static_cast<int>(expired.size());
    REQUIRE(expired == expected);
  }

  void lose_worker(WorkerId worker) {
    std::vector<Epoch> expected;
    for (auto& [epoch, r] : records_) {
      r.late.erase(worker);
      if (r.holders.erase(worker) > 0) {
        expected.push_back(epoch);
        retire_if_unheld(r, true);
      }
    }
    std::vector<Epoch> dropped;
    for (const Lease& lease : table_.drop_worker(worker)) dropped.push_back(lease.epoch);
    tally_.dropped += static_cast<int>(dropped.size());
    REQUIRE(dropped == expected);
  }

  void heartbeat() {
    const WorkerId worker = some_worker();
    const Epoch epoch = dice_.below(last_epoch_ + 2);
    const Time deadline = now_ + milliseconds(static_cast<std::int64_t>(dice_.below(200)));
    const auto found = records_.find(epoch);
    const bool holds = found != records_.end() && found->second.holders.contains(worker);
    if (holds) {
      Time& until = found->second.holders[worker];
      until = std::max(until, deadline);
      ++tally_.extended;
    }
    REQUIRE(table_.extend(worker, epoch, deadline) == holds);
  }

  /// Returns a range of done cells; {0, 0}: there is none.
  CellRange some_done() {
    const std::uint64_t begin = dice_.below(cells_.size());
    std::uint64_t end = begin;
    while (end < cells_.size() && cells_[end] == State::done && !dice_.one_in(4)) ++end;
    return end > begin ? CellRange{begin, end} : CellRange{};
  }

  void want_check() {
    const CellRange range = some_done();
    if (range.count() > 0) {
      want_check({range, {}, 0, {}, true, some_worker(), {}});
    } else if (dice_.one_in(4)) {
      place_orphans({1, 2}, some_worker());
    }
  }
  void want_check(const Record& check) {
    table_.want_check({check.range, check.by, check.not_by});
    checks_.push_back(check);
  }
  /// Gives failed checks, and checks of machines outside `able`, to `by`.
  void place_orphans(const std::set<MachineKey>& able, MachineKey by) {
    std::vector<Record> expected = std::exchange(failed_, {});
    for (const Record& check : checks_) {
      if (!able.contains(check.by)) expected.push_back(check);
    }
    std::erase_if(checks_, [&](const Record& check) { return !able.contains(check.by); });
    const auto orphans = table_.take_orphans(able);
    REQUIRE(orphans.size() == expected.size());
    for (std::size_t i = 0; i < orphans.size(); ++i) {
      REQUIRE(orphans[i].range == expected[i].range);
      REQUIRE(orphans[i].not_by == expected[i].not_by);
      expected[i].by = by;
      want_check(expected[i]);
      ++tally_.orphans;
    }
    REQUIRE(table_.checks_remain() == (!checks_.empty() || any_check_leased()));
  }
  [[nodiscard]] bool any_check_leased() const {
    return std::any_of(records_.begin(), records_.end(),
                       [](const auto& entry) { return entry.second.check && !entry.second.over; });
  }

  /// Puts back done cells, except cells that are being checked, which the model cannot handle.
  void put_back() {
    const CellRange range = some_done();
    if (range.count() > 0 && checks_.empty() && failed_.empty() && !any_check_leased()) {
      ++tally_.put_back;
      table_.put_back({range});
      REQUIRE(move(range, State::done, State::pending));
    }
  }

  void check_invariants() const {
    REQUIRE(table_.pending_cells() == count(State::pending));
    std::uint64_t leased_cells = 0;
    std::size_t leased = 0;
    std::map<WorkerId, std::size_t> held;
    Time next = never;
    for (const auto& [epoch, r] : records_) {
      if (!r.over) {
        ++leased;
        leased_cells += r.check ? 0 : r.range.count();
        REQUIRE(table_.range_of(epoch) == r.range);
      }
      for (const auto& [holder, deadline] : r.holders) {
        ++held[holder];
        next = std::min(next, deadline);
      }
    }
    REQUIRE(table_.leased() == leased);
    REQUIRE(leased_cells == count(State::leased));
    REQUIRE(table_.next_deadline() == next);
    REQUIRE(table_.idle() ==
            (leased == 0 && checks_.empty() && failed_.empty() && count(State::pending) == 0));
    for (WorkerId worker = 1; worker <= 5; ++worker) {
      REQUIRE(table_.held_by(worker) == held[worker]);
    }
  }

  /// Lets one working worker complete the history.
  void finish() {
    for (WorkerId worker = 1; worker <= 5; ++worker) lose_worker(worker);
    for (int turn = 0; !table_.idle(); ++turn) {
      REQUIRE(turn < 1000);
      merged();
      place_orphans({6}, 6);
      grant(6);
      for (Epoch epoch = 1; epoch <= last_epoch_; ++epoch) {
        if (records_.at(epoch).holders.erase(6) > 0) {
          records_.at(epoch).arrived = 6;
          REQUIRE(table_.arrive(6, epoch).kind != Arrival::stale);
        }
      }
    }
    check_invariants();
    REQUIRE(count(State::done) == cells_.size());
  }

  Dice dice_;
  HistoryTally& tally_;
  std::vector<State> cells_;
  std::uint64_t most_;
  LeaseTable table_;
  std::map<Epoch, Record> records_;   ///< every epoch ever granted
  std::vector<Record> checks_;        ///< wanted, in their order
  std::vector<Record> failed_;        ///< checks that another machine must make
  std::map<MachineKey, int> losses_;  ///< of checks in a row
  Epoch last_epoch_ = 0;
  Time now_{0};
};

}  // namespace

TEST_CASE("in 5000 random histories every cell is always in one state, and all histories end") {
  HistoryTally tally;
  for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
    CAPTURE(seed);
    History(seed, tally).run();
  }
  CHECK(tally.grants > 20'000);
  CHECK(tally.copies > 5000);
  CHECK(tally.checks > 1000);
  CHECK(tally.refusals > 1000);
  CHECK(tally.arrivals[Arrival::first] > 10'000);
  CHECK(tally.arrivals[Arrival::again] > 500);
  CHECK(tally.arrivals[Arrival::check] > 300);
  CHECK(tally.arrivals[Arrival::stale] > 10'000);
  CHECK(tally.no_good > 1000);
  CHECK(tally.expired > 1000);
  CHECK(tally.dropped > 1000);
  CHECK(tally.extended > 1000);
  CHECK(tally.put_back > 500);
  CHECK(tally.orphans > 500);
  CHECK(tally.parts > 500);
  CHECK(tally.late_parts > 50);
}

}  // namespace parray
