// Who checks which leases, what follows when bits differ, and which machines get no more leases.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/bytes.h"
#include "coordinator/disputes/merged.h"
#include "coordinator/disputes/undoing.h"
#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {
namespace {

/// Stands for the referee among those who checked cells. No machine_key() has this value.
constexpr TracerKey referee_tracer = 3;

/// Processor time that one question should take, in seconds.
constexpr double dispute_seconds = 0.25;
constexpr double check_seconds = 0.05;

/// Building the tree of a larger scene for a check would take the referee seconds.
constexpr std::uint64_t most_spheres_to_check = 2'000'000;

std::set<TracerKey> machines_of(const std::vector<ResultCollector::Differing>& cells) {
  std::set<TracerKey> machines;
  for (const auto& differing : cells) {
    machines.insert(differing.tracer);
  }
  return machines;
}

}  // namespace

/// Name of the worker that joined last from a machine, for people.
std::string Coordinator::worker_of(TracerKey machine) const {
  const std::string worker = machines_.find(machine).worker;
  return worker.empty() ? "one that has left" : worker;
}

/// A lease was accepted: it may be one that is checked. Its worker may have left meanwhile.
void Coordinator::draw_check(Job& job, const Merged& merged) {
  const CheckedWorker worker{machines_.count_lease(merged.machine), merged.process_leases,
                             merged.ours};
  if (checks_.wants_check(worker)) {
    place_check(job, {merged.arrived.range, 0, {merged.machine}});
  }
}

/// Gives a check to a machine drawn at random, or to the referee.
void Coordinator::place_check(Job& job, LeaseTable::Check check) {
  const std::vector<TracerKey> able = workers_.usable_machines(check.not_by);
  auto drawn = checks_.draw_checker(able.size());
  if (!drawn && check_by_referee(job, check.range)) {
    return;
  }
  if (able.empty()) {
    ++job.work->unchecked;
    return;
  }
  check.by = able[drawn ? *drawn : checks_.below(able.size())];
  job.work->leases->want_check(std::move(check));
  grants_due_ = true;
}

/// Checks whose machine has left, or has failed, go to others.
void Coordinator::place_orphans(Job& job) {
  for (LeaseTable::Check& check : job.work->leases->take_orphans(workers_.usable_machines())) {
    place_check(job, std::move(check));
  }
}

/// A case without its cells. `length`: seconds of processor time, of one question.
RefereeCase Coordinator::case_of(const Job& job, double length) const {
  constexpr double most_cells = 1024;
  constexpr std::uint64_t program = std::uint64_t{64} << 20;
  const JobWork& work = *job.work;
  const double price = work.price > 0 ? work.price : price_;
  RefereeCase made;
  made.generation = work.generation;
  made.plan = work.plan;
  made.scene = job.record.scene;
  made.parcel = work.scene;
  made.settings = job.record.settings;
  made.memory = program + 2 * work.scene.size() + work.facts.accelerator_bytes;
  made.cells_at_once = static_cast<std::uint64_t>(
      std::clamp(length / (work.plan->cell_samples() * price), 1.0, most_cells));
  return made;
}

/// The referee traces some of the cells, which are drawn at random. False: it cannot.
bool Coordinator::check_by_referee(Job& job, const CellRange& range) {
  if (job.spheres > most_spheres_to_check && workers_.usable_machines().size() > 1) {
    return false;
  }
  RefereeCase check = case_of(job, check_seconds);
  const std::uint64_t count = std::min(range.count(), check.cells_at_once);
  const std::uint64_t first = range.begin + checks_.below(range.count() - count + 1);
  for (std::uint64_t cell = first; cell < first + count; ++cell) {
    check.cells.push_back(cell);
  }
  return desk_.open(now_, std::move(check));
}

/// Cells that were done have come again.
void Coordinator::settle(Job& job, const Merged& merged) {
  if (merged.kind == Merged::Kind::differs) {
    ++tally_.mismatch;
    open_dispute(job, merged);
  } else {
    ++tally_.duplicate;
  }
}

/// The referee decides. The job goes on meanwhile, unless the referee cannot.
void Coordinator::open_dispute(Job& job, const Merged& merged) {
  std::set<TracerKey> voices = machines_of(merged.differing);
  const bool decided = quarantines_.find(merged.machine) != nullptr ||
                       std::ranges::all_of(voices, [&](TracerKey machine) {
                         return quarantines_.find(machine) != nullptr;
                       });
  if (decided) {
    return;  // compared before a quarantine set the cells back
  }
  RefereeCase dispute = case_of(job, dispute_seconds);
  dispute.dispute = true;
  dispute.claimant = merged.machine;
  for (const auto& differing : merged.differing) {
    dispute.cells.push_back(differing.cell);
    dispute.claims.push_back(merged.digests[differing.cell - merged.arrived.range.begin]);
  }
  if (!desk_.open(now_, std::move(dispute))) {
    voices.insert(merged.machine);
    place_check(job, {merged.arrived.range, 0, std::move(voices)});  // later
    return;
  }
  job.record.flag =
      fmt::format("workers '{}' and '{}' returned different bits for the same samples",
                  worker_of(merged.differing.front().tracer), merged.name);
  warnings_.warn(now_, fmt::format("job {} lease {}: {}: the referee decides", job.record.id,
                                   lease_number(merged.epoch), job.record.flag));
  if (desk_.disputes(job.work->generation) == 1) {
    note(job, job.record.flag);
    keep(job);
  }
}

/// Passes of which all cells are in wait for checks alone, whose machine may have failed or left.
void Coordinator::look_after_checks() {
  std::vector<JobId> waiting;
  for (const JobId id : at_work_) {
    const Job& job = jobs_.at(id);
    if (job.tracing() && job.work->cells >= job.work->plan->cells()) {
      waiting.push_back(id);
    }
  }
  for (const JobId id : waiting) {
    if (Job* job = job_of(id); job != nullptr && job->work) {
      end_pass_if_done(*job);
    }
  }
}

void Coordinator::take_referee_turn(Time now) {
  for (RefereeDesk::Traced& traced : desk_.take_answers(now)) {
    judge(std::move(traced));
  }
  if (desk_.may_ask(now)) {
    const std::uint64_t others = memory_in_use() - desk_.memory();
    desk_.ask_next(now, options_.memory - std::min(options_.memory, others));
  }
  if (desk_.disputes() > 0 || any_held_) {
    hold_disputed_jobs(now);
  }
}

/// What came of a question to the referee.
struct Coordinator::Judged {
  std::uint64_t number = 0;  ///< of the case
  bool dispute = false;
  TracerKey claimant = 0;
  CellRange range;
  bool timely = false;
  std::string fault;  ///< of the answer; empty: it is good
  bool claimant_wrong = false;
  std::set<TracerKey> wrong;  ///< machines whose merged bits are wrong
};

void Coordinator::judge(RefereeDesk::Traced traced) {
  const auto found = std::ranges::find_if(
      at_work_, [&](JobId id) { return job_at_work(id, traced.generation) != nullptr; });
  if (found == at_work_.end()) {
    desk_.close(traced.number);
    return;
  }
  Job& job = jobs_.at(*found);
  ++job.work->errands;
  const auto judged = std::make_shared<Judged>();
  judged->number = traced.number;
  judged->dispute = traced.dispute;
  judged->claimant = traced.claimant;
  judged->range = traced.range;
  const auto errands = for_job(job, "comparing what the referee traced");
  errands.give([this, judged, id = job.record.id, generation = traced.generation,
                claims = std::move(traced.claims), parcel = std::move(traced.cells),
                picture = job.work->picture, plan = job.work->plan, store = store_,
                depth = job.record.settings.max_depth]() -> Backroom::Outcome {
    judged->timely = picture->plan() == plan;
    try {
      if (judged->timely) {
        ResultCollector& collector = picture->collector();
        const auto truth = collector.digests_of(*parcel.open(plan->batch(judged->range), depth));
        judged->wrong = machines_of(collector.differing(judged->range, truth));
        judged->claimant_wrong = judged->dispute && claims != truth;
        if (judged->wrong.empty()) {
          picture->note_check(referee_tracer, judged->range);
          if (store != nullptr) {
            store->append_rows(id, picture->check_entry(referee_tracer, judged->range));
          }
        }
      }
    } catch (const DecodeError& error) {
      judged->fault = error.what();
    }
    return {[this, judged, id, generation] {
              Job* there = job_at_work(id, generation);
              if (there == nullptr) {
                desk_.close(judged->number);
                return;
              }
              --there->work->errands;
              note_judged(*there, *judged);
            },
            {}};
  });
}

void Coordinator::note_judged(Job& job, const Judged& judged) {
  grants_due_ = true;
  if (!judged.fault.empty()) {
    warnings_.warn(now_, "the referee's answer is no good: " + judged.fault);
    desk_.ask_again(now_, judged.number, judged.fault);
    return;
  }
  const std::string differs = "it returned wrong bits: the referee got others for the same samples";
  judged.wrong.empty() && !judged.claimant_wrong ? desk_.go_on(judged.number)
                                                 : desk_.close(judged.number);
  if (judged.claimant_wrong) {
    quarantine(judged.claimant, differs);
  }
  for (const TracerKey machine : judged.wrong) {
    quarantine(machine, differs);
  }
  if (job.work) {
    end_pass_if_done(job);
  }
}

/// Without the referee's word nothing is decided: no votes.
void Coordinator::hold_disputed_jobs(Time now) {
  any_held_ = false;
  for (const JobId id : at_work_) {
    Job& job = jobs_.at(id);
    if (!job.work) {
      continue;
    }
    const std::string why = desk_.hold(now, job.work->generation);
    if (why.empty() && !job.work->held) {
      continue;
    }
    if (!job.work->held) {
      log_->error("job {} is paused: {}", id, why);
    }
    grants_due_ = grants_due_ || why.empty();
    job.work->held = !why.empty();
    any_held_ = any_held_ || job.work->held;
    job.pause_reason = why;
  }
}

/// No more leases for this machine. All that it has traced in unfinished jobs is traced again, and
/// all that it has checked is checked again.
void Coordinator::quarantine(TracerKey machine, const std::string& reason) {
  const Machines::Known known = machines_.find(machine);
  const double at = options_.wall_clock();
  const bool fresh = quarantines_.add({machine, known.name, known.worker, reason, at, 0});
  const std::string name = worker_of(machine);
  if (fresh) {
    log_->error(
        "worker '{}' ({}) returns wrong bits: {}. Its machine gets no more leases, and what it "
        "traced is traced again. Test that machine, then: parray workers readmit",
        name, known.name, reason);
  }
  const Conviction conviction = convictions_.add(machine, name);
  keep_worker_notes();
  desk_.drop_claims(machine);
  const std::vector<WorkerRecord*> workers = workers_.of_machine(machine);
  for (WorkerRecord* worker : workers) {
    bar_as_due(*worker);
    scenes_.forget_worker(worker->id);
    worker->held = 0;
  }
  for (const JobId id : std::vector<JobId>(at_work_.begin(), at_work_.end())) {
    Job& job = jobs_.at(id);
    const bool made = job.phase == JobPhase::finishing && job.retry_at == never;
    if (made || !job.work || !job.work->leases) {
      continue;
    }
    if (job.phase == JobPhase::finishing) {  // there was no room for its picture: not yet, then
      job.phase = JobPhase::tracing;
      job.retry_at = never;
      job.pause_reason.clear();
    }
    for (const WorkerRecord* worker : workers) {
      job.work->leases->drop_worker(worker->id);
    }
    retract(job, conviction);
  }
  grants_due_ = true;
}

/// A job that was not at work at the time of a conviction may have kept rows of that machine.
void Coordinator::retract_later_convicted(Job& job) {
  for (const Conviction& conviction : convictions_.after(job.record.convictions)) {
    retract(job, conviction);
  }
}

/// What the backroom has set back.
struct Coordinator::Retracted {
  JobPicture::Retraction retraction;
  TracerKey machine = 0;
  bool relied = false;
  std::string flag;
  std::uint64_t conviction = 0;  ///< its number
  std::shared_ptr<const WorkPlan> plan;
  std::uint64_t samples = 0;
  std::uint64_t cells = 0;
};

void Coordinator::retract(Job& job, const Conviction& conviction) {
  const auto retracted = std::make_shared<Retracted>();
  retracted->machine = conviction.machine;
  retracted->conviction = conviction.number;
  ++job.work->errands;
  const auto errands = for_job(job, "setting back wrong results");
  errands.give([this, retracted, conviction, at = since_1970(now_), store = store_,
                id = job.record.id, record = job.record, picture = job.work->picture,
                generation = job.work->generation]() mutable -> Backroom::Outcome {
    const auto undone = undo(*picture, store, record, conviction, at);
    retracted->relied = undone.has_value();
    retracted->retraction = undone.value_or(JobPicture::Retraction{});
    retracted->flag = record.flag;
    retracted->plan = picture->plan();
    retracted->samples = picture->framebuffer().counts().samples;
    retracted->cells = picture->collector().done_cells();
    return {[this, retracted, id, generation] {
              if (Job* there = job_at_work(id, generation)) {
                note_retracted(*there, *retracted);
              }
            },
            {}};
  });
}

void Coordinator::note_retracted(Job& job, const Retracted& retracted) {
  JobWork& work = *job.work;
  --work.errands;
  job.record.convictions = std::max(job.record.convictions, retracted.conviction);
  if (retracted.relied) {
    job.record.flag = retracted.flag;
    note(job, retracted.flag);
    work.samples = retracted.samples;
    work.cells = retracted.cells;
    if (retracted.retraction.restarted) {
      job.record.passes = {};
      restart_leases(job, *retracted.plan);
    } else {
      work.leases->put_back(retracted.retraction.cells);
    }
    for (const CellRange& range : retracted.retraction.unchecked) {
      check_by_referee(job, range);
      place_check(job, {range, 0, {retracted.machine}});
    }
  }
  grants_due_ = true;
  end_pass_if_done(job);
}

void Coordinator::bar_as_due(WorkerRecord& worker) {
  const Quarantine* quarantine = quarantines_.find(worker.machine_key);
  worker.quarantine_ends = quarantine == nullptr ? 0 : quarantine->until;
  workers_.bar(worker, quarantine == nullptr ? "" : quarantine->reason, is_drained(worker));
}

/// Machines in quarantine of which no worker is connected, as worker maps.
nlohmann::json Coordinator::quarantined_elsewhere() {
  auto list = nlohmann::json::array();
  for (const auto& [machine, quarantine] : quarantines_.all()) {
    if (!workers_.of_machine(machine).empty()) {
      continue;
    }
    list.push_back({{"name", quarantine.worker},
                    {"host", ""},
                    {"threads", 0},
                    {"leases", 0},
                    {"accepted", 0},
                    {"samples_per_second", 0.0},
                    {"state", "quarantined"},
                    {"reason", quarantine.reason},
                    {"machine", quarantine.name},
                    {"quarantine_ends", quarantine.until},
                    {"seconds_silent", std::max(options_.wall_clock() - quarantine.since, 0.0)}});
  }
  return list;
}

/// Those of addresses end after a day.
void Coordinator::end_quarantines() {
  const std::vector<std::uint64_t> ended = quarantines_.expire(options_.wall_clock());
  if (ended.empty()) {
    return;
  }
  for (auto& [peer, worker] : workers_) {
    bar_as_due(worker);
  }
  log_->info("the quarantine of {} machines is over", ended.size());
  keep_worker_notes();
  grants_due_ = true;
}

}  // namespace parray::coordinator
