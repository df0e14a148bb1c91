#include <spdlog/spdlog.h>

#include <algorithm>
#include <random>

#include "common/base/bytes.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/disputes/merged.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/loop/farm.h"

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

/// Numbers that no worker can foresee. Opening the device takes far longer than a number.
static std::function<double()> unforeseeable() {
  return [device = std::make_shared<std::random_device>()] {
    return static_cast<double>((*device)()) * 0x1p-32;
  };
}

DisputeDesk::DisputeDesk(Farm& farm, JobBook& job_book)
    : farm_(farm),
      job_book_(job_book),
      checks_(farm.options.checks, farm.options.random ? farm.options.random : unforeseeable()),
      desk_(farm.options.referee, farm.options.refereeing) {}

/// A lease was accepted: it may be one that is checked. Its worker may have left meanwhile.
void DisputeDesk::draw_check(Job& job, const Merged& merged) {
  const CheckedWorker worker{farm_.machines.count_lease(merged.machine), merged.process_leases,
                             merged.ours};
  if (checks_.wants_check(worker)) {
    place_check(job, {merged.arrived.range, 0, {merged.machine}});
  }
}

/// Gives a check to a machine drawn at random, or to the referee.
void DisputeDesk::place_check(Job& job, LeaseTable::Check check) {
  const std::vector<TracerKey> able = farm_.workers.usable_machines(check.not_by);
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
  farm_.grants_due = true;
}

/// Checks whose machine has left, or has failed, go to others.
void DisputeDesk::place_orphans(Job& job) {
  for (LeaseTable::Check& check : job.work->leases->take_orphans(farm_.workers.usable_machines())) {
    place_check(job, std::move(check));
  }
}

/// A case without its cells. `length`: seconds of processor time, of one question.
RefereeCase DisputeDesk::case_of(const Job& job, double length) const {
  constexpr double most_cells = 1024;
  constexpr std::uint64_t program = std::uint64_t{64} << 20;
  const JobWork& work = *job.work;
  const double price = work.price > 0 ? work.price : farm_.price;
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
bool DisputeDesk::check_by_referee(Job& job, const CellRange& range) {
  if (job.spheres > most_spheres_to_check && farm_.workers.usable_machines().size() > 1) {
    return false;
  }
  RefereeCase check = case_of(job, check_seconds);
  const std::uint64_t count = std::min(range.count(), check.cells_at_once);
  const std::uint64_t first = range.begin + checks_.below(range.count() - count + 1);
  for (std::uint64_t cell = first; cell < first + count; ++cell) {
    check.cells.push_back(cell);
  }
  return desk_.open(farm_.now, std::move(check));
}

/// Cells that were done have come again.
void DisputeDesk::compare_result(Job& job, const Merged& merged) {
  if (merged.kind == Merged::Kind::differs) {
    ++farm_.tally.mismatch;
    open_dispute(job, merged);
  } else {
    ++farm_.tally.duplicate;
  }
}

/// The referee decides. The job goes on meanwhile, unless the referee cannot.
void DisputeDesk::open_dispute(Job& job, const Merged& merged) {
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
  if (!desk_.open(farm_.now, std::move(dispute))) {
    voices.insert(merged.machine);
    place_check(job, {merged.arrived.range, 0, std::move(voices)});  // later
    return;
  }
  job.record.flag =
      fmt::format("workers '{}' and '{}' returned different bits for the same samples",
                  worker_of(merged.differing.front().tracer), merged.name);
  farm_.warnings.warn(farm_.now,
                      fmt::format("job {} lease {}: {}: the referee decides", job.record.id,
                                  farm_.lease_number(merged.epoch), job.record.flag));
  if (desk_.disputes(job.work->generation) == 1) {
    farm_.note(job, job.record.flag);
    farm_.keep(job);
  }
}

/// Passes of which all cells are in wait for checks alone, whose machine may have failed or left.
void DisputeDesk::look_after_checks() {
  std::vector<JobId> waiting;
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.tracing() && job.work->cells >= job.work->plan->cells()) {
      waiting.push_back(id);
    }
  }
  for (const JobId id : waiting) {
    if (Job* job = farm_.job_of(id); job != nullptr && job->work) {
      job_book_.end_pass_if_done(*job);
    }
  }
}

void DisputeDesk::take_referee_turn(Time now) {
  for (RefereeDesk::Traced& traced : desk_.take_answers(now)) {
    judge(std::move(traced));
  }
  if (desk_.may_ask(now)) {
    const std::uint64_t others = job_book_.memory_in_use() - desk_.memory();
    desk_.ask_next(now, farm_.options.memory - std::min(farm_.options.memory, others));
  }
  if (desk_.disputes() > 0 || any_held_) {
    hold_disputed_jobs(now);
  }
}

/// What came of a question to the referee.
struct DisputeDesk::Judged {
  std::uint64_t number = 0;  ///< of the case
  bool dispute = false;
  TracerKey claimant = 0;
  CellRange range;
  bool timely = false;
  std::string fault;  ///< of the answer; empty: it is good
  bool claimant_wrong = false;
  std::set<TracerKey> wrong;  ///< machines whose merged bits are wrong
};

void DisputeDesk::judge(RefereeDesk::Traced traced) {
  const auto found = std::ranges::find_if(
      farm_.at_work, [&](JobId id) { return farm_.job_at_work(id, traced.generation) != nullptr; });
  if (found == farm_.at_work.end()) {
    desk_.close(traced.number);
    return;
  }
  Job& job = farm_.jobs.at(*found);
  ++job.work->errands;
  const auto judged = std::make_shared<Judged>();
  judged->number = traced.number;
  judged->dispute = traced.dispute;
  judged->claimant = traced.claimant;
  judged->range = traced.range;
  const auto errands = job_book_.for_job(job, "comparing what the referee traced");
  errands.give([this, judged, id = job.record.id, generation = traced.generation,
                claims = std::move(traced.claims), parcel = std::move(traced.cells),
                picture = job.work->picture, plan = job.work->plan, store = farm_.store,
                depth = max_depth_of(job.record.settings)]() -> Backroom::Outcome {
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
              Job* there = farm_.job_at_work(id, generation);
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

void DisputeDesk::note_judged(Job& job, const Judged& judged) {
  farm_.grants_due = true;
  if (!judged.fault.empty()) {
    farm_.warnings.warn(farm_.now, "the referee's answer is no good: " + judged.fault);
    desk_.ask_again(farm_.now, judged.number, judged.fault);
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
    job_book_.end_pass_if_done(job);
  }
}

/// Without the referee's word nothing is decided: no votes.
void DisputeDesk::hold_disputed_jobs(Time now) {
  any_held_ = false;
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work) {
      continue;
    }
    const std::string why = desk_.hold(now, job.work->generation);
    if (why.empty() && !job.work->held) {
      continue;
    }
    if (!job.work->held) {
      farm_.log->error("job {} is paused: {}", id, why);
    }
    farm_.grants_due = farm_.grants_due || why.empty();
    job.work->held = !why.empty();
    any_held_ = any_held_ || job.work->held;
    job.pause_reason = why;
  }
}

}  // namespace parray::coordinator
