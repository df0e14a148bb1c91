#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "coordinator/lease_table.h"
#include "tests/support/dice.h"
#include "tests/support/lease_model.h"

/// Random histories of a lease table against a model that keeps a state for every single sample.
namespace parray {
namespace {

using test::Dice;
using Model = test::LeaseModel;
using enum msg::Verdict;

/// How often each thing happened over all histories: what never happens proves nothing.
struct Tally {
  int grants = 0;
  int copies = 0;
  int refusals = 0;
  std::map<msg::Verdict, int> verdicts;
  int late_but_current = 0;
  int expired = 0;
  int dropped = 0;
  int extended = 0;
  int restarts = 0;
  int parts_of_rows = 0;
};

class History {
 public:
  History(std::uint64_t seed, Tally& tally)
      : dice_(seed),
        tally_(tally),
        settings_(random_settings()),
        table_(std::make_unique<LeaseTable>(settings_, 1)),
        model_(settings_.height, settings_.samples_per_pixel) {}

  void run() {
    for (std::uint64_t step = dice_.below(120); step > 0; --step) {
      switch (dice_.below(16)) {
        case 0:
        case 1:
        case 2:
        case 3:
        case 4:
          grant(dice_.one_in(2));
          break;
        case 5:
        case 6:
        case 7:
        case 8:
          result();
          break;
        case 9:
          foreign_result();
          break;
        case 10:
          pass_time();
          break;
        case 11:
          lose_worker(some_worker());
          break;
        case 12:
        case 13:
        case 14:
          heartbeat();
          break;
        default:
          if (dice_.one_in(4)) restart();
          break;
      }
      check_invariants();
    }
    finish();
  }

 private:
  RenderSettings random_settings() {
    RenderSettings settings;
    settings.width = dice_.one_in(8) ? 65536 : 16;
    settings.height = 1 + dice_.below32(20);
    settings.samples_per_pixel = 1 + dice_.below32(dice_.one_in(3) ? 2 : 16);
    settings.schedule = static_cast<SchedulePolicy>(dice_.below(4));
    return settings;
  }

  WorkerId some_worker() { return 1 + dice_.below(5); }

  void grant(bool may_copy) {
    Asker asker;
    asker.worker = some_worker();
    asker.threads = 1 + dice_.below32(4);
    asker.share = dice_.one_in(4) ? 1 : dice_.unit() + 1e-6;
    asker.workers = dice_.below32(8);
    asker.least_units = 1 + dice_.below(dice_.one_in(2) ? 3 : 40);
    asker.most_units = asker.least_units + dice_.below(100);
    const Time deadline = now_ + milliseconds(1 + static_cast<std::int64_t>(dice_.below(100)));
    const auto lease = table_->grant(deadline, asker, may_copy);
    if (!lease) {
      ++tally_.refusals;
      REQUIRE(model_.count(Model::Cell::pending) == 0);
      REQUIRE((!may_copy || oldest_to_copy(asker.worker) == 0));
      return;
    }
    if (lease->copy) {
      ++tally_.copies;
      REQUIRE(may_copy);
      REQUIRE(model_.count(Model::Cell::pending) == 0);
      REQUIRE(lease->epoch == oldest_to_copy(asker.worker));
      REQUIRE(lease->rect == model_.records[lease->epoch].rect);
    } else {
      ++tally_.grants;
      tally_.parts_of_rows += lease->rect.samples() < settings_.samples_per_pixel ? 1 : 0;
      REQUIRE(lease->epoch > last_epoch_);  // never used before, in no life of the job
      REQUIRE(lease->rect.row_end <= settings_.height);
      REQUIRE(lease->rect.sample_end <= settings_.samples_per_pixel);
      REQUIRE(lease->rect.units() > 0);
      REQUIRE(model_.move(lease->rect, Model::Cell::pending, Model::Cell::leased));
      last_epoch_ = lease->epoch;
      model_.records[lease->epoch].rect = lease->rect;
    }
    model_.records[lease->epoch].holders[asker.worker] = deadline;
  }

  /// The lease that a copy must be of; 0: none.
  [[nodiscard]] Epoch oldest_to_copy(WorkerId worker) const {
    for (const auto& [epoch, record] : model_.records) {
      if (record.state == Model::State::leased && !record.holders.contains(worker) &&
          record.holders.size() < LeaseTable::most_holders) {
        return epoch;
      }
    }
    return 0;
  }

  /// The bits of some samples; the same whoever computes them.
  static ResultDigest digest_of_rect(const WorkRect& rect) {
    return rect.row_begin * 1000003ULL + rect.row_end * 10007ULL + rect.sample_begin * 101ULL +
           rect.sample_end;
  }

  /// Some lease of the past or present is returned, in time, late or again, and at times wrongly.
  void result() {
    if (model_.records.empty()) {
      return;
    }
    auto chosen = model_.records.begin();
    std::advance(chosen, static_cast<std::ptrdiff_t>(dice_.below(model_.records.size())));
    auto& [epoch, record] = *chosen;
    const bool broken = dice_.one_in(10);
    const ResultDigest digest = digest_of_rect(record.rect) + (broken ? 1 : 0);
    complete(some_worker(), epoch, record, record.rect, digest);
  }

  void complete(WorkerId worker, Epoch epoch, Model::Record& record, const WorkRect& rect,
                ResultDigest digest) {
    msg::Verdict expected = stale;
    if (record.state == Model::State::done) {
      expected = rect == record.rect && digest == record.digest ? duplicate : mismatch;
    } else if (record.state == Model::State::leased && rect == record.rect) {
      expected = accepted;
    }
    const auto completion = table_->complete(worker, epoch, rect, digest);
    ++tally_.verdicts[completion.verdict];
    REQUIRE(completion.verdict == expected);
    std::vector<WorkerId> others;
    if (expected == accepted) {
      tally_.late_but_current += record.holders.contains(worker) ? 0 : 1;
      for (const auto& [holder, deadline] : record.holders) {
        if (holder != worker) {
          others.push_back(holder);
        }
      }
      REQUIRE(model_.move(rect, Model::Cell::leased, Model::Cell::done));
      record.state = Model::State::done;
      record.digest = digest;
      record.holders.clear();
    }
    auto named = completion.others;
    std::sort(named.begin(), named.end());
    REQUIRE(named == others);
  }

  /// A result that no grant explains: an epoch of another life, or a rectangle of its own.
  void foreign_result() {
    const WorkRect rect{0, 1, 0, 1 + dice_.below32(settings_.samples_per_pixel)};
    const Epoch epoch = dice_.below(last_epoch_ + 3);
    const auto found = model_.records.find(epoch);
    if (found != model_.records.end()) {
      complete(some_worker(), epoch, found->second, rect, digest_of_rect(rect));
    } else {
      REQUIRE(table_->complete(some_worker(), epoch, rect, 7).verdict == stale);
    }
  }

  void pass_time() {
    now_ += milliseconds(static_cast<std::int64_t>(dice_.below(60)));
    std::vector<std::pair<Epoch, WorkerId>> expected;
    bool good = true;
    for (auto& [epoch, record] : model_.records) {
      for (const auto& [holder, deadline] : record.holders) {
        if (deadline <= now_) {
          expected.emplace_back(epoch, holder);
        }
      }
      std::erase_if(record.holders, [&](const auto& holder) { return holder.second <= now_; });
      model_.retire_if_unheld(record, good);
    }
    REQUIRE(good);
    std::vector<std::pair<Epoch, WorkerId>> expired;
    for (const auto& [epoch, worker] : table_->expire(now_)) {
      expired.emplace_back(epoch, worker);
    }
    std::sort(expired.begin(), expired.end());
    tally_.expired += static_cast<int>(expired.size());
    REQUIRE(expired == expected);
  }

  void lose_worker(WorkerId worker) {
    std::vector<Epoch> expected;
    bool good = true;
    for (auto& [epoch, record] : model_.records) {
      if (record.holders.erase(worker) > 0) {
        expected.push_back(epoch);
        model_.retire_if_unheld(record, good);
      }
    }
    REQUIRE(good);
    tally_.dropped += static_cast<int>(expected.size());
    REQUIRE(table_->drop_worker(worker) == expected);
  }

  void heartbeat() {
    const WorkerId worker = some_worker();
    const Epoch epoch = dice_.below(last_epoch_ + 2);
    const Time deadline = now_ + milliseconds(static_cast<std::int64_t>(dice_.below(200)));
    const auto record = model_.records.find(epoch);
    const bool holds = record != model_.records.end() && record->second.holders.contains(worker);
    if (holds) {
      Time& until = record->second.holders[worker];
      until = std::max(until, deadline);
      ++tally_.extended;
    }
    REQUIRE(table_->extend(worker, epoch, deadline) == holds);
  }

  /// The coordinator dies; some of what was done had not reached the disk.
  void restart() {
    ++tally_.restarts;
    Model next(settings_.height, settings_.samples_per_pixel);
    std::vector<WorkRect> kept;
    for (const auto& [epoch, record] : model_.records) {
      if (record.state == Model::State::done && !dice_.one_in(5)) {
        kept.push_back(record.rect);
      }
    }
    for (const WorkRect& rect : restored_) {
      kept.push_back(rect);
    }
    for (std::size_t i = kept.size(); i > 1; --i) {
      std::swap(kept[i - 1], kept[dice_.below(i)]);
    }
    table_ = std::make_unique<LeaseTable>(settings_, last_epoch_ + 1);
    for (const WorkRect& rect : kept) {
      table_->restore(rect);
      REQUIRE(next.move(rect, Model::Cell::pending, Model::Cell::done));
    }
    restored_ = std::move(kept);
    model_ = std::move(next);
  }

  void check_invariants() const {
    const std::uint64_t pending = model_.count(Model::Cell::pending);
    const std::uint64_t done = model_.count(Model::Cell::done);
    REQUIRE(table_->pending_units() == pending);
    REQUIRE(table_->has_pending() == (pending > 0));
    REQUIRE(table_->done_units() == done);
    REQUIRE(table_->done() == (done == table_->total_units()));
    REQUIRE(table_->progress() ==
            static_cast<double>(done) / static_cast<double>(table_->total_units()));
    std::uint64_t leased_units = 0;
    std::size_t leased = 0;
    std::map<WorkerId, std::size_t> held;
    Time next = never;
    for (const auto& [epoch, record] : model_.records) {
      if (record.state == Model::State::leased) {
        ++leased;
        leased_units += record.rect.units();
      }
      for (const auto& [holder, deadline] : record.holders) {
        ++held[holder];
        next = std::min(next, deadline);
      }
    }
    REQUIRE(table_->leased() == leased);
    REQUIRE(pending + leased_units + done == table_->total_units());
    REQUIRE(table_->next_deadline() == next);
    for (WorkerId worker = 1; worker <= 5; ++worker) {
      REQUIRE(table_->held_by(worker) == held[worker]);
    }
  }

  /// One good worker is enough for any history to end.
  void finish() {
    for (WorkerId worker = 1; worker <= 5; ++worker) {
      lose_worker(worker);
    }
    std::uint64_t turns = 0;
    while (!table_->done()) {
      REQUIRE(++turns <= table_->total_units());
      grant(true);
      for (auto& [epoch, record] : model_.records) {
        if (record.state == Model::State::leased) {
          complete(1, epoch, record, record.rect, digest_of_rect(record.rect));
        }
      }
    }
    check_invariants();
    REQUIRE(model_.each_merged_once());
    REQUIRE(table_->leased() == 0);
  }

  Dice dice_;
  Tally& tally_;
  RenderSettings settings_;
  std::unique_ptr<LeaseTable> table_;
  Model model_;
  std::vector<WorkRect> restored_;
  Epoch last_epoch_ = 0;
  Time now_{0};
};

}  // namespace

TEST_CASE("5000 random histories merge every sample exactly once and end") {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
    CAPTURE(seed);
    History(seed, tally).run();
  }
  CHECK(tally.grants > 20'000);
  CHECK(tally.copies > 1000);
  CHECK(tally.refusals > 1000);
  CHECK(tally.verdicts[accepted] > 10'000);
  CHECK(tally.verdicts[duplicate] > 1000);
  CHECK(tally.verdicts[stale] > 1000);
  CHECK(tally.verdicts[mismatch] > 500);
  CHECK(tally.late_but_current > 500);
  CHECK(tally.expired > 1000);
  CHECK(tally.dropped > 1000);
  CHECK(tally.extended > 1000);
  CHECK(tally.restarts > 500);
  CHECK(tally.parts_of_rows > 1000);
}

}  // namespace parray
