#include <spdlog/spdlog.h>

#include <algorithm>
#include <random>

#include "common/base/bytes.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/loop/backoff.h"

namespace parray::coordinator {
namespace {

/// The referee as a tracer that checked cells. No machine_key() has this value.
constexpr TracerKey referee_tracer = 3;

/// Processor time that one question to the referee should take, in seconds.
constexpr double dispute_seconds = 0.25;
constexpr double check_seconds = 0.05;

std::set<TracerKey> machines_of(const std::vector<ResultCollector::Differing>& cells) {
  std::set<TracerKey> machines;
  for (const auto& differing : cells) machines.insert(differing.tracer);
  return machines;
}

}  // namespace

/// Returns a source of unpredictable numbers. It keeps the device open, because opening is slow.
static std::function<double()> random_source() {
  return [device = std::make_shared<std::random_device>()] {
    return static_cast<double>((*device)()) * 0x1p-32;
  };
}

DisputeDesk::DisputeDesk(Farm& farm, JobBook& job_book)
    : farm_(farm),
      job_book_(job_book),
      checks_(farm.options.checks, farm.options.random ? farm.options.random : random_source()),
      desk_(farm.options.referee, farm.options.refereeing) {}

void DisputeDesk::draw_check(Job& job, const Merged& merged) {
  const CheckedWorker worker{farm_.machines.count_lease(merged.machine), merged.process_leases,
                             merged.ours};
  if (checks_.wants_check(worker)) {
    if (!checks_.checks_all()) keep_wanted(job, merged.arrived.range);
    place_check(job, {merged.arrived.range, 0, {merged.machine}});
  }
}

/// Stores that a check was drawn, so that the next coordinator makes it if this one does not. With
/// --spot-checks 1 that is known.
void DisputeDesk::keep_wanted(const Job& job, const CellRange& range) {
  if (farm_.store == nullptr) return;
  auto task = [run = job.work->run, plan = job.work->plan, range]() -> JobThread::Completion {
    if (run->picture().plan() == plan) run->note_wanted(range);
    return {};
  };
  job_book_.for_job(job, "storing that a check is wanted", std::move(task));
}

/// Returns until when checks wait for a machine not in `not_by` that may return: one that has just
/// been lost, one whose backoff ends soon, or, after a restart of the coordinator, any.
Time DisputeDesk::latest_return(const Job& job, const std::set<TracerKey>& not_by) const {
  const Time patience = 3 * farm_.options.lease_timeout;
  const Time lost = farm_.machines.last_lost([&](TracerKey machine) {
    return !not_by.contains(machine) && quarantines_.find(machine) == nullptr;
  });
  Time back = lost == Time::min() ? lost : lost + patience;
  for (const auto& [peer, worker] : farm_.workers) {
    if (worker.state() == "backoff" && !not_by.contains(worker.machine_key) &&
        worker.held_back_until <= farm_.now + Backoff::first) {
      back = std::max(back, worker.held_back_until + farm_.options.heartbeat);
    }
  }
  const bool recovered = job.submitted == never;
  return recovered ? std::max(back, farm_.began + patience) : back;
}

/// Gives a check to a machine drawn at random, or lets it wait for one. The referee traces only
/// some of the cells, so it replaces no machine.
void DisputeDesk::place_check(Job& job, LeaseTable::Check check) {
  const std::vector<TracerKey> able = farm_.workers.usable_machines(check.not_by);
  const Time until = able.empty() ? latest_return(job, check.not_by) : Time::min();
  if (farm_.now < until) {
    check.by = 0;
    job.work->leases->want_check(std::move(check));
    farm_.grant_again_at = std::min(farm_.grant_again_at, until);
    return;
  }
  const auto drawn = checks_.draw_checker(able.size());
  const bool refereed = !drawn && check_by_referee(job, check.range, able.empty());
  if (able.empty()) {
    job.work->unchecked += refereed ? 0 : 1;
    return;
  }
  check.by = able[drawn ? *drawn : checks_.below(able.size())];
  job.work->leases->want_check(std::move(check));
  farm_.grants_due = true;
}

void DisputeDesk::place_orphans(Job& job) {
  if (job.work->started == never && farm_.workers.size() == 0) {
    return;  // the coordinator has just started: the workers are not back yet
  }
  const std::vector<TracerKey> able = farm_.workers.usable_machines();
  for (LeaseTable::Check& check : job.work->leases->take_orphans({able.begin(), able.end()})) {
    place_check(job, std::move(check));
  }
}

/// Makes a case without cells. `length`: processor time of one question, in seconds.
RefereeCase DisputeDesk::case_of(const Job& job, double length) const {
  constexpr double most_cells = 1024;
  constexpr std::uint64_t program = std::uint64_t{64} << 20;
  const JobWork& work = *job.work;
  const double price = work.price > 0 ? work.price : farm_.price;
  RefereeCase made;
  made.generation = work.generation;
  made.plan = work.plan;
  made.scene = job.record.scene;
  made.payload = work.scene;
  made.settings = job.record.settings;
  made.memory = program + 2 * work.scene.size() + work.facts.accelerator_bytes;
  made.cells_at_once = static_cast<std::uint64_t>(
      std::clamp(length / (work.plan->cell_samples() * price), 1.0, most_cells));
  return made;
}

/// Lets the referee check some random cells of the range. `sole`: no machine checks the range.
/// False: the referee cannot.
bool DisputeDesk::check_by_referee(Job& job, const CellRange& range, bool sole) {
  if (job.spheres > farm_.options.checks.most_spheres &&
      farm_.workers.usable_machines().size() > 1) {
    return false;
  }
  RefereeCase check = case_of(job, check_seconds);
  const std::uint64_t count = std::min(range.count(), check.cells_at_once);
  const std::uint64_t first = range.begin + checks_.below(range.count() - count + 1);
  for (std::uint64_t cell = first; cell < first + count; ++cell) check.cells.push_back(cell);
  const bool too_few = sole && checks_.checks_all() && count < range.count();
  check.sole = sole && !too_few;
  if (!desk_.open(farm_.now, std::move(check))) return false;
  job.work->unchecked += too_few ? 1 : 0;
  return true;
}

void DisputeDesk::compare_result(Job& job, const Merged& merged) {
  if (merged.kind == Merged::Kind::differs) {
    ++farm_.tally.mismatch;
    open_dispute(job, merged);
  } else {
    ++farm_.tally.duplicate;
  }
}

/// Asks the referee to decide. The job continues meanwhile, unless the referee cannot decide.
void DisputeDesk::open_dispute(Job& job, const Merged& merged) {
  std::set<TracerKey> machines = machines_of(merged.differing);
  const bool decided = quarantines_.find(merged.machine) != nullptr ||
                       std::ranges::all_of(machines, [&](TracerKey machine) {
                         return quarantines_.find(machine) != nullptr;
                       });
  if (decided) {
    return;  // this comparison happened before a quarantine retracted the cells
  }
  RefereeCase dispute = case_of(job, dispute_seconds);
  dispute.dispute = true;
  dispute.claimant = merged.machine;
  for (const auto& differing : merged.differing) {
    dispute.cells.push_back(differing.cell);
    dispute.claims.push_back(merged.digests[differing.cell - merged.arrived.range.begin]);
  }
  if (!desk_.open(farm_.now, std::move(dispute))) {
    machines.insert(merged.machine);
    place_check(job, {merged.arrived.range, 0, std::move(machines)});  // a third machine checks
    return;
  }
  job.record.flag =
      fmt::format("workers '{}' and '{}' returned different bits for the same samples",
                  worker_of(merged.differing.front().tracer), merged.name);
  farm_.warnings.warn(
      farm_.now, fmt::format("job {} lease {}: {}: the referee will trace them again",
                             job.record.id, farm_.lease_number(merged.epoch), job.record.flag));
  if (desk_.disputes(job.work->generation) == 1) {
    farm_.note(job, job.record.flag);
    farm_.keep(job);
  }
}

/// A pass whose cells are all merged waits for checks whose machine may have failed or left.
void DisputeDesk::look_after_checks() {
  std::vector<JobId> waiting;
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.tracing() && job.work->cells >= job.work->plan->cells()) waiting.push_back(id);
  }
  for (const JobId id : waiting) {
    if (Job* job = farm_.job_of(id); job != nullptr && job->work) job_book_.end_pass_if_done(*job);
  }
}

void DisputeDesk::take_referee_turn(Time now) {
  for (RefereeDesk::Traced& traced : desk_.take_answers(now)) check_answer(std::move(traced));
  if (desk_.may_ask(now)) {
    const std::uint64_t others = job_book_.memory_in_use() - desk_.memory();
    desk_.ask_next(now, farm_.options.memory - std::min(farm_.options.memory, others));
  }
  if (desk_.disputes() > 0 || any_held_) hold_disputed_jobs(now);
}

/// The outcome of a question to the referee.
struct DisputeDesk::CheckedAnswer {
  RefereeDesk::Traced traced;  ///< without claims and cells
  std::string fault;           ///< what is wrong with the answer; empty: nothing
  bool claimant_wrong = false;
  std::set<TracerKey> wrong;  ///< machines whose merged bits are wrong
};

void DisputeDesk::check_answer(RefereeDesk::Traced traced) {
  const auto found = std::ranges::find_if(
      farm_.at_work, [&](JobId id) { return farm_.job_at_work(id, traced.generation) != nullptr; });
  if (found == farm_.at_work.end()) {
    desk_.close(traced.number);
    return;
  }
  Job& job = farm_.jobs.at(*found);
  ++job.work->tasks;
  const auto checked = std::make_shared<CheckedAnswer>();
  checked->traced = std::move(traced);
  auto task = [this, checked, id = job.record.id,
               claims = std::exchange(checked->traced.claims, {}),
               payload = std::exchange(checked->traced.cells, {}), run = job.work->run,
               plan = job.work->plan,
               depth = max_depth_of(job.record.settings)]() -> JobThread::Completion {
    const CellRange& range = checked->traced.range;
    try {
      if (run->picture().plan() == plan) {  // the pass of the question has not ended
        const ResultCollector& collector = run->picture().collector();
        const auto truth = collector.digests_of(*payload.open(plan->batch(range), depth));
        checked->wrong = machines_of(collector.differing(range, truth));
        checked->claimant_wrong = checked->traced.dispute && claims != truth;
        if (checked->wrong.empty()) run->note_check(referee_tracer, range);
      }
    } catch (const DecodeError& error) {
      checked->fault = error.what();
    }
    return {[this, checked, id] {
      Job* there = farm_.job_at_work(id, checked->traced.generation);
      if (there == nullptr) {
        desk_.close(checked->traced.number);
        return;
      }
      --there->work->tasks;
      note_checked_answer(*there, *checked);
    }};
  };
  job_book_.for_job(job, "comparing the referee's results", std::move(task));
}

void DisputeDesk::note_checked_answer(Job& job, const CheckedAnswer& checked) {
  const std::uint64_t number = checked.traced.number;
  farm_.grants_due = true;
  if (!checked.fault.empty()) {
    farm_.warnings.warn(farm_.now, "the referee's answer is invalid: " + checked.fault);
    desk_.ask_again(farm_.now, number, checked.fault);
    return;
  }
  const std::string differs = "its bits differ from the referee's for the same samples";
  checked.wrong.empty() && !checked.claimant_wrong ? desk_.continue_case(number)
                                                   : desk_.close(number);
  if (checked.claimant_wrong) quarantine(checked.traced.claimant, differs);
  for (const TracerKey machine : checked.wrong) quarantine(machine, differs);
  if (job.work) job_book_.end_pass_if_done(job);
}

/// Pauses jobs whose disputes the referee has not decided. Other machines do not vote.
void DisputeDesk::hold_disputed_jobs(Time now) {
  any_held_ = false;
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work) continue;
    const std::string why = desk_.hold(now, job.work->generation);
    if (why.empty() && !job.work->held) continue;
    if (!job.work->held) farm_.log->error("job {} is paused: {}", id, why);
    farm_.grants_due = farm_.grants_due || why.empty();
    job.work->held = !why.empty();
    any_held_ = any_held_ || job.work->held;
    job.pause_reason = why;
  }
}

}  // namespace parray::coordinator
