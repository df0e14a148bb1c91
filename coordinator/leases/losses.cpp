// Leases that come to nothing: workers that are lost, that fail, that make no progress.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>
#include <vector>

#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {

/// `failed`: it may be the lease at hand that has ended it.
void Coordinator::lose_worker(Time now, const PeerId& peer, const std::string& why, bool failed) {
  const WorkerRecord* found = workers_.at(peer);
  if (found == nullptr) {
    return;
  }
  const WorkerRecord worker = *found;
  workers_.remove(peer);
  scenes_.forget_worker(worker.id);
  grants_due_ = true;
  const auto has_its_name = [&](const auto& other) {
    return other.second.hello.name == worker.hello.name;
  };
  const bool started_again =
      worker.tracing.has_value() && std::any_of(workers_.begin(), workers_.end(), has_its_name);
  std::size_t leases = 0;
  for (const JobId id : std::vector<JobId>(at_work_.begin(), at_work_.end())) {
    Job& job = jobs_.at(id);
    if (!job.work || !job.work->leases) {
      continue;
    }
    for (const Lease& lease : job.work->leases->drop_worker(worker.id)) {
      ++leases;
      if (failed && worker.tracing == std::pair(id, lease.epoch)) {
        note_failure(now, job,
                     {lease.range, worker.machine, worker.key, worker.hello.name,
                      "a worker was lost while it traced this: " + why, true, !started_again});
      }
      if (!job.work) {
        break;  // that was one too many
      }
    }
    if (job.tracing()) {
      end_pass_if_done(job);
    }
  }
  arrivals_.info(now, fmt::format("worker {} '{}' left ({}); {} of its leases go to others",
                                  worker.id, worker.hello.name, why, leases));
}

void Coordinator::judge_losses(Time now, const WorkerRecord& worker) {
  for (const JobId id : at_work_) {
    Job& job = jobs_.at(id);
    if (!job.work) {
      continue;
    }
    JobFailures& failures = job.work->failures;
    for (const Failure& death :
         failures.note_joined(worker.machine, worker.key, worker.hello.name)) {
      if (failures.any_success()) {
        backoff_.note_failure(now, death.machine, death.name,
                              !failures.has_succeeded(death.machine));
      }
    }
  }
}

void Coordinator::expire_leases(Time now) {
  for (const JobId id : at_work_) {
    Job& job = jobs_.at(id);
    if (!job.work || !job.work->leases) {
      continue;
    }
    for (const auto& expired : job.work->leases->expire(now)) {
      grants_due_ = true;
      if (WorkerRecord* worker = workers_.by_id(expired.worker)) {
        --worker->held;
      }
      warnings_.warn(now, fmt::format("job {} lease {}: worker {} made no progress in time; the "
                                      "lease goes to another",
                                      id, lease_number(expired.lease.epoch), expired.worker));
    }
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::Failed& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) {
    return;
  }
  send(peer, msg::Revoke{m.job, m.epoch});  // it need not say so again
  Job* job = job_of(m.job);
  if (job == nullptr || !job->work || !job->work->leases) {
    return;
  }
  const auto range = job->work->leases->range_of(m.epoch);
  if (!range || !job->work->leases->give_back(worker->id, m.epoch)) {
    return;
  }
  --worker->held;
  ++tally_.failed;
  grants_due_ = true;
  // Others first: they may be able to do what it cannot.
  worker->shunned[m.job] = now + options_.heartbeat;
  grant_again_at_ = std::min(grant_again_at_, now + options_.heartbeat);
  note_failure(now, *job, {*range, worker->machine, worker->key, worker->hello.name, m.reason});
}

/// A job that no machine can trace fails. A worker that fails where others succeed is held back.
void Coordinator::note_failure(Time now, Job& job, Failure failure) {
  warnings_.warn(
      now, fmt::format("job {}: worker '{}' could not trace cells [{}, {}): {}", job.record.id,
                       failure.name, failure.range.begin, failure.range.end, failure.reason));
  note(job, fmt::format("worker '{}' could not trace a part: {}", failure.name, failure.reason));
  JobFailures& failures = job.work->failures;
  failures.add(failure);
  const bool others_succeed = std::ranges::any_of(job.work->contributors, [&](WorkerId id) {
    const WorkerRecord* other = workers_.by_id(id);
    return other != nullptr && other->key != failure.worker;
  });
  if (others_succeed && !failure.excused) {
    backoff_.note_failure(now, failure.machine, failure.name,
                          !failures.has_succeeded(failure.machine));
    hold_back(now);
  }
  std::vector<AbleWorker> able;
  for (const auto& [peer, worker] : workers_) {
    if (worker.may_trace()) {
      able.push_back({worker.machine, worker.key});
    }
  }
  const std::uint32_t most =
      job.record.max_failures > 0 ? job.record.max_failures : options_.max_failures;
  if (const auto who = failures.verdict(failure.range, able, most)) {
    fail_job(job, fmt::format("{} (so failed {}, the last worker '{}')", failure.reason, *who,
                              failure.name));
  }
}

/// A result was accepted: whoever has failed at this job is at fault, not the job.
void Coordinator::note_success(Job& job, WorkerId id) {
  const WorkerRecord* worker = workers_.by_id(id);
  if (worker == nullptr) {
    return;
  }
  JobFailures& failures = job.work->failures;
  const bool first = !failures.any_success();
  failures.note_success(worker->machine);
  const bool forgiven = backoff_.note_success(worker->machine, worker->hello.name);
  if (!first) {
    if (forgiven) {
      hold_back(now_);
    }
    return;
  }
  for (const Failure& failure : failures.all()) {
    if (!failure.excused && failure.worker != worker->key) {
      backoff_.note_failure(now_, failure.machine, failure.name,
                            failure.machine != worker->machine);
    }
  }
  hold_back(now_);
}

/// Brings what the registry knows of backoffs up to date. The worker's next leases come when its
/// time is over.
void Coordinator::hold_back(Time now) {
  for (auto& [peer, worker] : workers_) {
    const Time until = backoff_.until(worker.machine, worker.hello.name);
    if (until > now && worker.held_back_until != until) {
      log_->warn("worker '{}' fails where others succeed: no leases for {:.0f} s",
                 worker.hello.name, to_seconds(until - now));
    }
    if ((until > now) != worker.held_back || worker.held_back_until != until) {
      workers_.hold_back(worker, until > now, until);
      grants_due_ = true;
    }
    if (until > now) {
      grant_again_at_ = std::min(grant_again_at_, until);
    }
  }
}

}  // namespace parray::coordinator
