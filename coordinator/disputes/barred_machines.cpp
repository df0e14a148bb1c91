#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/json_text.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"

namespace parray::coordinator {

using nlohmann::json;

void DisputeDesk::drain(const std::string& name, bool host, const std::string& asker) {
  drained_.insert({host, name});
  for (auto& [peer, worker] : farm_.workers) apply_bars(worker);
  farm_.log->info("{} drained {} '{}'", asker, host ? "host" : "worker", name);
  farm_.announce(FarmEventKind::drained, host ? "" : name,
                 fmt::format("{}drained by {}", host ? "host '" + name + "' " : "", asker));
}

void DisputeDesk::readmit(const std::string& name, bool host) {
  drained_.erase({host, name});
  quarantines_.readmit(name, host);
  for (auto& [peer, worker] : farm_.workers) {
    if ((host ? worker.hello.host : worker.hello.name) == name) {
      drained_.erase({false, worker.hello.name});
      quarantines_.readmit(worker.machine_key);
    }
  }
  for (auto& [peer, worker] : farm_.workers) apply_bars(worker);
}

void DisputeDesk::keep_worker_notes() {
  if (farm_.store == nullptr) return;
  json drained = json::array();
  for (const auto& [host, name] : drained_) drained.push_back({host, name});
  const json notes = {{"drained", std::move(drained)},
                      {"quarantines", quarantines_.to_json()},
                      {"convictions", fault_findings_.to_json()}};
  auto task = [store = farm_.store, text = json_text(notes)]() -> JobThread::Completion {
    store->put_note("workers", text);
    return {};
  };
  farm_.for_log("storing the note of workers", std::move(task));
}

void DisputeDesk::restore_worker_notes() {
  const std::string text = farm_.store == nullptr ? "" : farm_.store->note("workers");
  if (text.empty()) return;
  try {
    const json notes = json::parse(text);
    for (const json& drained : notes.at("drained")) {
      drained_.insert({drained.at(0).get<bool>(), drained.at(1).get<std::string>()});
    }
    quarantines_ = QuarantineLedger::from_json(notes.at("quarantines"));
    fault_findings_ = FaultFindings::from_json(notes.at("convictions"));
  } catch (const json::exception& error) {
    throw damaged_worker_note(error.what());
  }
}

/// Returns the name of the worker that joined last from a machine, for people.
std::string DisputeDesk::worker_of(TracerKey machine) const {
  const std::string worker = farm_.machines.find(machine).worker;
  return worker.empty() ? "unknown" : worker;
}

void DisputeDesk::quarantine(TracerKey machine, const std::string& reason) {
  if (farm_.options.on_quarantine) farm_.options.on_quarantine(reason);
  const Machines::Known known = farm_.machines.find(machine);
  const double at = farm_.options.wall_clock();
  const bool fresh =
      quarantines_.add({machine, known.name, known.worker, known.host, reason, at, 0});
  const std::string name = worker_of(machine);
  if (fresh) {
    farm_.log->error(
        "worker '{}' ({}) returned wrong bits: {}. Its machine gets no more leases, and other "
        "machines trace its cells again. Test the machine, then run parray workers readmit NAME",
        name, known.name, reason);
    farm_.announce(FarmEventKind::quarantined, name, fmt::format("{}: {}", known.name, reason));
  }
  const FaultFinding finding = fault_findings_.add(machine, name);
  keep_worker_notes();
  desk_.drop_claims(machine);
  const std::vector<WorkerRecord*> workers = farm_.workers.of_machine(machine);
  for (WorkerRecord* worker : workers) {
    apply_bars(*worker);
    farm_.scenes.forget_worker(worker->id);
    worker->held = 0;
  }
  for (const JobId id : std::vector<JobId>(farm_.at_work.begin(), farm_.at_work.end())) {
    Job& job = farm_.jobs.at(id);
    const bool made = job.phase == JobPhase::finishing && job.retry_at == never;
    if (made || !job.work || !job.work->leases) continue;
    if (job.phase == JobPhase::finishing) {  // it waits for room on the disk: trace again first
      job.phase = JobPhase::tracing;
      job.retry_at = never;
      job.pause_reason.clear();
    }
    for (const WorkerRecord* worker : workers) job.work->leases->drop_worker(worker->id);
    retract(job, finding);
  }
  farm_.grants_due = true;
}

void DisputeDesk::retract_later_faulty(Job& job) {
  for (const FaultFinding& finding : fault_findings_.after(job.record.fault_findings)) {
    retract(job, finding);
  }
}

/// What the job thread has retracted.
struct DisputeDesk::Retracted {
  std::optional<JobPicture::Retraction> retraction;  ///< empty: no results or checks of the machine
  FaultFinding finding;
  std::string flag;
  RunState state;
};

void DisputeDesk::retract(Job& job, const FaultFinding& finding) {
  const auto retracted = std::make_shared<Retracted>();
  retracted->finding = finding;
  ++job.work->tasks;
  auto task = [this, retracted, at = farm_.since_1970(farm_.now), id = job.record.id,
               record = job.record, run = job.work->run,
               generation = job.work->generation]() mutable -> JobThread::Completion {
    run->put(std::move(record));
    retracted->retraction = run->retract(retracted->finding, at);
    retracted->flag = run->record().flag;
    retracted->state = run->state();
    return {[this, retracted, id, generation] {
      if (Job* there = farm_.job_at_work(id, generation)) note_retracted(*there, *retracted);
    }};
  };
  job_book_.for_job(job, "retracting wrong results", std::move(task));
}

void DisputeDesk::note_retracted(Job& job, const Retracted& retracted) {
  JobWork& work = *job.work;
  --work.tasks;
  job.record.fault_findings = std::max(job.record.fault_findings, retracted.finding.number);
  if (retracted.retraction) {
    job.record.flag = retracted.flag;
    farm_.note(job, retracted.flag);
    if (retracted.retraction->restarted) {
      job_book_.restart_leases(job, retracted.state);
    } else {
      static_cast<RunState&>(work) = retracted.state;
      work.leases->put_back(retracted.retraction->cells);
    }
    for (const auto& [range, tracer] : retracted.retraction->unchecked) {
      check_by_referee(job, range, false);
      place_check(job, {range, 0, {tracer, retracted.finding.machine}});
    }
  }
  farm_.grants_due = true;
  job_book_.end_pass_if_done(job);
}

void DisputeDesk::note_joined(WorkerRecord& worker) {
  farm_.machines.note(worker.machine, worker.hello);
  apply_bars(worker);
}

void DisputeDesk::apply_bars(WorkerRecord& worker) {
  const Quarantine* quarantine = quarantines_.find(worker.machine_key);
  const bool drained =
      drained_.contains({false, worker.hello.name}) || drained_.contains({true, worker.hello.host});
  worker.quarantine_ends = quarantine == nullptr ? 0 : quarantine->until;
  farm_.workers.bar(worker, quarantine == nullptr ? "" : quarantine->reason, drained);
}

/// Lists each machine under the name of the worker that joined last.
nlohmann::json DisputeDesk::quarantined_elsewhere() {
  auto list = nlohmann::json::array();
  for (const auto& [machine, quarantine] : quarantines_.all()) {
    if (!farm_.workers.of_machine(machine).empty()) continue;
    list.push_back(
        {{"name", quarantine.worker},
         {"host", quarantine.host},
         {"threads", 0},
         {"leases", 0},
         {"accepted", 0},
         {"samples_per_second", 0.0},
         {"state", "quarantined"},
         {"reason", quarantine.reason},
         {"machine", quarantine.name},
         {"quarantine_ends", quarantine.until},
         {"seconds_silent", std::max(farm_.options.wall_clock() - quarantine.since, 0.0)}});
  }
  return list;
}

void DisputeDesk::end_quarantines() {
  const std::size_t ended = quarantines_.expire(farm_.options.wall_clock());
  if (ended == 0) return;
  for (auto& [peer, worker] : farm_.workers) apply_bars(worker);
  farm_.log->info("the quarantine of {} machines has ended", ended);
  farm_.announce(FarmEventKind::readmitted, "",
                 fmt::format("the quarantine of {} machines has ended", ended));
  keep_worker_notes();
  farm_.grants_due = true;
}

}  // namespace parray::coordinator
