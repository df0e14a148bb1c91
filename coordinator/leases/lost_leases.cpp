#include <spdlog/spdlog.h>

#include <algorithm>
#include <vector>

#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

void LeaseDesk::check_losses(Time now, const WorkerRecord& worker) {
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work) continue;
    JobFailures& failures = job.work->failures;
    const bool survived = std::ranges::any_of(failures.all(), [&](const Failure& failure) {
      return failure.by_loss && !failure.excused && failure.worker == worker.key;
    });
    if (survived) {  // another process of its machine joined first, so it was believed dead
      backoff_.forgive(worker.machine, worker.hello.name);
    }
    for (const Failure& death :
         failures.note_joined(worker.machine, worker.key, worker.hello.name)) {
      if (failures.any_success()) {
        backoff_.note_failure(now, death.machine, death.name,
                              !failures.has_succeeded(death.machine));
      }
    }
  }
}

void LeaseDesk::expire_leases(Time now) {
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work || !job.work->leases) continue;
    for (const auto& expired : job.work->leases->expire(now)) {
      farm_.grants_due = true;
      if (WorkerRecord* worker = farm_.workers.by_id(expired.worker)) {
        --worker->held;
        worker->note_failure(now, id, "it made no progress in time");
      }
      farm_.warnings.warn(now,
                          fmt::format("job {} lease {}: worker {} made no progress in time and "
                                      "lost the lease",
                                      id, farm_.lease_number(expired.lease.epoch), expired.worker));
    }
  }
}

void LeaseDesk::on(Time now, const PeerId& peer, msg::Failed& m) {
  WorkerRecord* worker = worker_desk_.heard_from(now, peer);
  if (worker == nullptr) return;
  farm_.send(peer, msg::Revoke{m.job, m.epoch});  // so that the worker does not repeat it
  Job* job = farm_.job_of(m.job);
  if (job == nullptr || !job->work || !job->work->leases) return;
  const auto range = job->work->leases->range_of(m.epoch);
  if (!range || !job->work->leases->give_back(worker->id, m.epoch)) return;
  --worker->held;
  ++farm_.tally.failed;
  worker->note_failure(now, m.job, m.reason);
  farm_.grants_due = true;
  // Other workers may be able to trace these cells and get leases of this job first.
  worker->denied_jobs[m.job] = now + farm_.options.heartbeat;
  farm_.grant_again_at = std::min(farm_.grant_again_at, now + farm_.options.heartbeat);
  note_failure(now, *job, {*range, worker->machine, worker->key, worker->hello.name, m.reason});
}

void LeaseDesk::note_failure(Time now, Job& job, Failure failure) {
  farm_.warnings.warn(
      now, fmt::format("job {}: worker '{}' could not trace cells [{}, {}): {}", job.record.id,
                       failure.name, failure.range.begin, failure.range.end, failure.reason));
  farm_.note(job,
             fmt::format("worker '{}' could not trace a part: {}", failure.name, failure.reason));
  JobFailures& failures = job.work->failures;
  failures.add(failure);
  const bool others_succeed = std::ranges::any_of(job.work->contributors, [&](WorkerId id) {
    const WorkerRecord* other = farm_.workers.by_id(id);
    return other != nullptr && other->key != failure.worker;
  });
  if (others_succeed && !failure.excused) {
    backoff_.note_failure(now, failure.machine, failure.name,
                          !failures.has_succeeded(failure.machine));
    hold_back(now);
  }
  std::vector<AbleWorker> able;
  for (const auto& [peer, worker] : farm_.workers) {
    if (worker.may_trace()) able.push_back({worker.machine, worker.key});
  }
  const std::uint32_t most =
      job.record.max_failures > 0 ? job.record.max_failures : farm_.options.max_failures;
  if (const auto who = failures.verdict(failure.range, able, most)) {
    job_book_.fail_job(job, fmt::format("{} (failed on {}, last on worker '{}')", failure.reason,
                                        *who, failure.name));
  }
}

/// From the first accepted result on, failures count against the workers, not against the job.
void LeaseDesk::note_success(Job& job, WorkerId id) {
  const WorkerRecord* worker = farm_.workers.by_id(id);
  if (worker == nullptr) return;
  JobFailures& failures = job.work->failures;
  const bool first = !failures.any_success();
  failures.note_success(worker->machine);
  const bool forgiven = backoff_.note_success(worker->machine, worker->hello.name);
  if (!first) {
    if (forgiven) hold_back(farm_.now);
    return;
  }
  for (const Failure& failure : failures.all()) {
    if (!failure.excused && failure.worker != worker->key) {
      backoff_.note_failure(farm_.now, failure.machine, failure.name,
                            failure.machine != worker->machine);
    }
  }
  hold_back(farm_.now);
}

void LeaseDesk::hold_back(Time now) {
  for (auto& [peer, worker] : farm_.workers) {
    const Time until = backoff_.until(worker.machine, worker.hello.name);
    if (until > now && worker.held_back_until != until) {
      farm_.log->warn("worker '{}' failed where others succeed: it gets no leases for {:.0f} s",
                      worker.hello.name, to_seconds(until - now));
      farm_.announce(FarmEventKind::backoff, worker.hello.name,
                     fmt::format("failed where others succeed: no leases for {:.0f} s",
                                 to_seconds(until - now)));
    }
    if ((until > now) != worker.held_back || worker.held_back_until != until) {
      farm_.workers.hold_back(worker, until > now, until);
      farm_.grants_due = true;
    }
    if (until > now) farm_.grant_again_at = std::min(farm_.grant_again_at, until);
  }
}

Time LeaseDesk::next_deadline() const {
  Time next = never;
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.work && job.work->leases) next = std::min(next, job.work->leases->next_deadline());
  }
  return next;
}

void LeaseDesk::forgive(const WorkerRecord& worker) {
  backoff_.forgive(worker.machine, worker.hello.name);
}

}  // namespace parray::coordinator
