#include "cli/check/audit/replay.h"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <tuple>

#include "common/base/error.h"
#include "coordinator/leases/lease_table.h"

namespace parray::audit {
namespace {

/// Thread-seconds of the cells of a pass. Runs of cells are disjoint.
class Costs {
 public:
  /// Needs cells without costs.
  void add(const CellRange& range, double thread_seconds) {
    each_[range.begin] = {range.end, thread_seconds / static_cast<double>(range.count())};
  }
  void remove(const CellRange& range) {
    auto at = each_.upper_bound(range.begin);
    at = at == each_.begin() ? at : std::prev(at);
    while (at != each_.end() && at->first < range.end) {
      const auto [begin, run] = *at;
      if (run.end <= range.begin) {
        ++at;
        continue;
      }
      at = each_.erase(at);
      if (begin < range.begin) each_[begin] = {range.begin, run.each};
      if (run.end > range.end) each_[range.end] = {run.end, run.each};
    }
  }
  [[nodiscard]] double of(const CellRange& range) const {
    double sum = 0;
    auto at = each_.upper_bound(range.begin);
    at = at == each_.begin() ? at : std::prev(at);
    for (; at != each_.end() && at->first < range.end; ++at) {
      const std::uint64_t begin = std::max(range.begin, at->first);
      const std::uint64_t end = std::min(range.end, at->second.end);
      sum += begin < end ? static_cast<double>(end - begin) * at->second.each : 0;
    }
    return sum;
  }

 private:
  struct Run {
    std::uint64_t end = 0;
    double each = 0;
  };
  std::map<std::uint64_t, Run> each_;
};

struct RecordedPass {
  JournalPass pass;
  Costs costs;
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

  [[nodiscard]] double work() const { return pass_.costs.of({0, pass_.pass.cells}); }
  [[nodiscard]] std::uint64_t leases() const { return leases_.next_epoch() - 1; }

 private:
  void ask(double now, WorkerId worker) {
    const Time far = never;
    auto lease = leases_.grant(far, worker, {workers_[worker].threads, speeds_[worker]}, farm_);
    if (!lease) lease = leases_.grant_copy(far, worker);
    if (lease) events_.emplace(now + seconds_of(worker, lease->range), worker, lease->epoch);
  }

  [[nodiscard]] double seconds_of(WorkerId worker, const CellRange& range) const {
    return pass_.costs.of(range) / (workers_[worker].threads * workers_[worker].speed);
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

}  // namespace

static double power_of(const std::vector<ImaginedWorker>& workers) {
  double power = 0;
  for (const ImaginedWorker& worker : workers) power += worker.threads * worker.speed;
  return power;
}

Replayed replay_job(const std::vector<JournalEntry>& journal, const ReplayOptions& options) {
  const Recorded job = recorded(journal);
  std::vector<ImaginedWorker> workers;
  for (const auto& [tracer, each] : job.threads) {
    workers.insert(workers.end(), options.copies, {std::max(each, 1U), 1});
  }
  Replayed result;
  double work = 0;
  for (const auto& [number, pass] : job.passes) {
    if (workers.empty()) break;
    if (pass.pass.cells == 0) {
      throw RunError("the journal is damaged: it has results of pass " + std::to_string(number) +
                     ", which never began");
    }
    PassReplay replay(pass, workers, options.policy);
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
