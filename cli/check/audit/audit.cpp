#include "cli/check/audit/audit.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <tuple>

#include "common/base/error.h"
#include "coordinator/leases/lease_table.h"

namespace parray::audit {
namespace {

/// Disjoint runs of cells of a pass, with the thread-seconds of each cell.
class CellRuns {
 public:
  /// Adds a range. Returns false, and changes nothing, if it contains some of the cells already.
  bool add(const CellRange& range, double thread_seconds = 0) {
    const auto next = first_behind(range.begin);
    if (next != runs_.end() && next->first < range.end) return false;
    runs_[range.begin] = {range.end, thread_seconds / static_cast<double>(range.count())};
    cells_ += range.count();
    return true;
  }

  /// Removes a range. Returns false if it lacks some of the cells.
  bool remove(const CellRange& range) {
    const std::uint64_t before = cells_;
    for (auto at = first_behind(range.begin); at != runs_.end() && at->first < range.end;) {
      const auto [begin, run] = *at;
      cells_ -= shared({begin, run.end}, range);
      at = runs_.erase(at);
      if (begin < range.begin) runs_[begin] = {range.begin, run.each};
      if (run.end > range.end) at = runs_.try_emplace(range.end, run).first;
    }
    return before - cells_ == range.count();
  }

  [[nodiscard]] std::uint64_t cells() const { return cells_; }
  [[nodiscard]] double thread_seconds(const CellRange& range) const {
    double sum = 0;
    for (auto at = first_behind(range.begin); at != runs_.end() && at->first < range.end; ++at) {
      sum += static_cast<double>(shared({at->first, at->second.end}, range)) * at->second.each;
    }
    return sum;
  }

 private:
  struct Run {
    std::uint64_t end = 0;
    double each = 0;
  };
  using Runs = std::map<std::uint64_t, Run>;  ///< by their first cells

  /// Returns the first run that ends behind the cell `begin`.
  [[nodiscard]] Runs::const_iterator first_behind(std::uint64_t begin) const {
    const auto next = runs_.upper_bound(begin);
    const bool inside = next != runs_.begin() && std::prev(next)->second.end > begin;
    return inside ? std::prev(next) : next;
  }
  /// Returns the number of cells that are in both ranges, which overlap.
  static std::uint64_t shared(const CellRange& a, const CellRange& b) {
    return std::min(a.end, b.end) - std::max(a.begin, b.begin);
  }

  Runs runs_;
  std::uint64_t cells_ = 0;
};

// ---- Audit -----------------------------------------------------------------------------------

class Auditor {
 public:
  void take(const JournalWorker& e) {
    workers_[e.tracer] = audit_.workers.size();
    audit_.workers.push_back({e.name, e.threads, 0, 0, 0});
  }

  void take(const JournalPass& e) {
    if (passes_.contains(e.pass)) {
      problem("pass " + std::to_string(e.pass) + " begins twice");
      return;
    }
    passes_[e.pass].first = e.cells;
    audit_.cells += e.cells;
    ++audit_.passes;
  }

  void take(const JournalGrid& /*entry*/) {}

  void take(const JournalMerge& e) {
    ++audit_.leases;
    const auto pass = passes_.find(e.pass);
    const auto worker = workers_.find(e.tracer);
    if (pass == passes_.end() || e.range.end > pass->second.first) {
      problem(text(e.pass, e.range) + " belong to a pass that has not begun");
    } else if (worker == workers_.end()) {
      problem(text(e.pass, e.range) + " were merged by an unknown worker");
    } else if (!epochs_.insert(e.epoch).second) {
      problem("a lease of " + text(e.pass, e.range) + " was merged twice");
    } else if (!pass->second.second.add(e.range)) {
      problem(text(e.pass, e.range) + " were merged, but some of them had been merged before");
    } else {
      Audit::Worker& by = audit_.workers[worker->second];
      ++by.leases;
      by.cells += e.range.count();
      by.seconds += e.seconds;
    }
  }

  void take(const JournalRetraction& e) {
    for (const CellRange& range : e.cells) {
      audit_.set_back += range.count();
      if (!passes_[e.pass].second.remove(range)) {
        problem(text(e.pass, range) + " were set back, but not all of them had been merged");
      }
    }
  }

  Audit finish() {
    for (const auto& [number, pass] : passes_) audit_.merged += pass.second.cells();
    return std::move(audit_);
  }

 private:
  static std::string text(std::uint32_t pass, const CellRange& range) {
    return "cells " + std::to_string(range.begin) + " to " + std::to_string(range.end - 1) +
           " of pass " + std::to_string(pass);
  }

  void problem(std::string line) {
    constexpr std::size_t most = 100;
    if (audit_.problems.size() < most) audit_.problems.push_back(std::move(line));
  }

  Audit audit_;
  std::map<TracerKey, std::size_t> workers_;  ///< indices in Audit::workers
  std::map<std::uint32_t, std::pair<std::uint64_t, CellRuns>> passes_;  ///< all and merged cells
  std::set<std::uint64_t> epochs_;
};

}  // namespace

Audit audit_journal(const std::vector<JournalEntry>& journal) {
  Auditor auditor;
  for (const JournalEntry& entry : journal) {
    std::visit([&](const auto& e) { auditor.take(e); }, entry);
  }
  return auditor.finish();
}

// ---- Time spent ------------------------------------------------------------------------------

namespace {

struct Span {
  std::uint32_t threads = 0;
  double first_granted = std::numeric_limits<double>::infinity();
  double first_arrived = 0;
  double first_traced = 0;
  double last_arrived = 0;
  double traced = 0;
};

std::map<TracerKey, Span> spans_of(const std::vector<JournalEntry>& journal) {
  std::map<TracerKey, Span> spans;
  for (const JournalEntry& entry : journal) {
    if (const auto* worker = std::get_if<JournalWorker>(&entry)) {
      spans[worker->tracer].threads = worker->threads;
    } else if (const auto* merge = std::get_if<JournalMerge>(&entry)) {
      Span& span = spans[merge->tracer];
      if (merge->granted < span.first_granted) {
        span.first_granted = merge->granted;
        span.first_arrived = merge->arrived;
        span.first_traced = merge->seconds;
      }
      span.last_arrived = std::max(span.last_arrived, merge->arrived);
      span.traced += merge->seconds;
    }
  }
  std::erase_if(spans, [](const auto& span) { return span.second.last_arrived == 0; });
  return spans;
}

}  // namespace

TimeSpent time_spent(const std::vector<JournalEntry>& journal) {
  const auto spans = spans_of(journal);
  if (spans.empty()) return {};
  double begin = std::numeric_limits<double>::infinity();
  double end = 0;
  for (const auto& [tracer, span] : spans) {
    begin = std::min(begin, span.first_granted);
    end = std::max(end, span.last_arrived);
  }
  TimeSpent spent;
  spent.seconds = end - begin;
  spent.workers = spans.size();
  double had = 0;
  for (const auto& [tracer, span] : spans) {
    const double start = std::max(span.first_arrived - span.first_granted - span.first_traced, 0.0);
    spent.threads += span.threads;
    had += span.threads * (end - span.first_granted);
    spent.tracing += span.threads * span.traced;
    spent.start += span.threads * start;
    spent.tail += span.threads * (end - span.last_arrived);
  }
  had = std::max(had, std::numeric_limits<double>::min());
  for (double* const part : {&spent.tracing, &spent.start, &spent.tail}) {
    *part = std::min(*part / had, 1.0);
  }
  spent.between = std::max(1 - spent.tracing - spent.start - spent.tail, 0.0);
  return spent;
}

// ---- Replay ----------------------------------------------------------------------------------

namespace {

struct RecordedPass {
  JournalPass pass;
  CellRuns costs;
};

struct Recorded {
  std::map<std::uint32_t, RecordedPass> passes;
  std::map<TracerKey, std::uint32_t> threads;  ///< of workers with merged results
};

Recorded recorded(const std::vector<JournalEntry>& journal) {
  Recorded result;
  std::map<TracerKey, std::uint32_t> known;
  for (const JournalEntry& entry : journal) {
    if (const auto* worker = std::get_if<JournalWorker>(&entry)) {
      known[worker->tracer] = worker->threads;
    } else if (const auto* pass = std::get_if<JournalPass>(&entry)) {
      result.passes[pass->pass].pass = *pass;
    } else if (const auto* merge = std::get_if<JournalMerge>(&entry)) {
      const std::uint32_t threads = known[merge->tracer];
      result.threads[merge->tracer] = threads;
      result.passes[merge->pass].costs.add(merge->range, merge->seconds * threads);
    } else if (const auto* wrong = std::get_if<JournalRetraction>(&entry)) {
      for (const CellRange& cells : wrong->cells) result.passes[wrong->pass].costs.remove(cells);
    }
  }
  return result;
}

class PassReplay {
 public:
  PassReplay(const RecordedPass& pass, const std::vector<ImaginedWorker>& workers,
             SchedulePolicy policy)
      : pass_(pass),
        workers_(workers),
        speeds_(workers.size()),
        leases_(ChunkSizer(policy, pass.pass.grain, LeaseLength{}), {{0, pass.pass.cells}}, 1) {
    farm_ = {0, 0, 0, static_cast<std::uint32_t>(workers.size())};
    for (const ImaginedWorker& worker : workers) farm_.threads += worker.threads;
  }

  double run() {
    for (WorkerId worker = 0; worker < workers_.size(); ++worker) ask(0, worker);
    double now = 0;
    while (!events_.empty()) {
      const auto [at, worker, epoch] = events_.top();
      events_.pop();
      const auto range = leases_.range_of(epoch);
      if (leases_.arrive(worker, epoch).kind != LeaseTable::Arrival::first) {
        continue;  // the result of another copy arrived earlier
      }
      now = at;
      measure(worker, *range);
      for (const WorkerId other : leases_.finish(epoch)) ask(now, other);
      ask(now, worker);
    }
    return now;
  }

  [[nodiscard]] double work() const { return pass_.costs.thread_seconds({0, pass_.pass.cells}); }
  [[nodiscard]] std::uint64_t leases() const { return leases_.next_epoch() - 1; }

 private:
  void ask(double now, WorkerId worker) {
    const Time far = never;
    auto lease = leases_.grant(far, worker, {workers_[worker].threads, speeds_[worker]}, farm_);
    if (!lease) lease = leases_.grant_copy(far, worker);
    if (lease) events_.emplace(now + seconds_of(worker, lease->range), worker, lease->epoch);
  }

  [[nodiscard]] double seconds_of(WorkerId worker, const CellRange& range) const {
    return pass_.costs.thread_seconds(range) / (workers_[worker].threads * workers_[worker].speed);
  }

  void measure(WorkerId worker, const CellRange& range) {
    const double seconds = seconds_of(worker, range);
    if (seconds <= 0) return;
    const double speed =
        pass_.pass.grain.cell_samples * static_cast<double>(range.count()) / seconds;
    if (speeds_[worker] == 0) farm_.measured_threads += workers_[worker].threads;
    farm_.samples_per_second += speed - speeds_[worker];
    speeds_[worker] = speed;
  }

  const RecordedPass& pass_;
  const std::vector<ImaginedWorker>& workers_;
  std::vector<double> speeds_;  ///< measured, in samples/s; 0: not yet measured
  LeaseTable leases_;
  FarmSpeed farm_;
  using Event = std::tuple<double, WorkerId, Epoch>;  ///< the end of a lease
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
};

double power_of(const std::vector<ImaginedWorker>& workers) {
  double power = 0;
  for (const ImaginedWorker& worker : workers) power += worker.threads * worker.speed;
  return power;
}

}  // namespace

Replayed replay_job(const std::vector<JournalEntry>& journal, SchedulePolicy policy,
                    std::uint32_t copies) {
  const Recorded job = recorded(journal);
  std::vector<ImaginedWorker> workers;
  for (const auto& [tracer, each] : job.threads) {
    workers.insert(workers.end(), copies, {std::max(each, 1U), 1});
  }
  Replayed result;
  double work = 0;
  for (const auto& [number, pass] : job.passes) {
    if (workers.empty()) break;
    if (pass.pass.cells == 0) {
      throw RunError("the journal is damaged: it has results of pass " + std::to_string(number) +
                     ", which never began");
    }
    PassReplay replay(pass, workers, policy);
    work += replay.work();
    result.seconds += replay.run();
    result.leases += replay.leases();
  }
  if (result.seconds <= 0) {
    throw RunError("the journal has no result to replay: wait for the first result of the job");
  }
  result.efficiency = work / (result.seconds * power_of(workers));
  return result;
}

Replayed replay_even_pass(const ChunkGrain& grain, double thread_seconds,
                          const std::vector<ImaginedWorker>& workers, SchedulePolicy policy) {
  RecordedPass pass;
  pass.pass.cells = grain.cells;
  pass.pass.grain = grain;
  pass.costs.add({0, grain.cells}, thread_seconds);
  PassReplay replay(pass, workers, policy);
  const double took = replay.run();
  return {took, thread_seconds / (took * power_of(workers)), replay.leases()};
}

}  // namespace parray::audit
