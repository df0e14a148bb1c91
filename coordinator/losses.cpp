// Leases that come to nothing: workers that are lost, that fail, that make no progress.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "coordinator/coordinator.h"

namespace parray {

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
  for (const JobId id : std::vector<JobId>(open_jobs_)) {
    Job& job = jobs_.at(id);
    if (!job.work || !job.work->leases) {
      continue;
    }
    for (const Lease& lease : job.work->leases->drop_worker(worker.id)) {
      ++leases;
      if (failed && worker.tracing == std::pair(id, lease.epoch)) {
        note_failure(
            now, job,
            {lease.range, worker.hello.name, "a worker was lost while it traced this: " + why,
             started_again ? 0 : worker.key});
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

/// A worker that was lost is back: no lease has ended it. Or another process of its name is there:
/// one may have.
void Coordinator::judge_losses(const WorkerRecord& worker) {
  const auto is_its = [&](const Failure& failure) { return failure.lost == worker.key; };
  for (const JobId id : open_jobs_) {
    Job& job = jobs_.at(id);
    if (!job.work) {
      continue;
    }
    auto& failures = job.work->failures;
    const auto old = failures.begin() + static_cast<std::ptrdiff_t>(job.work->old_failures);
    job.work->old_failures -=
        static_cast<std::size_t>(std::count_if(failures.begin(), old, is_its));
    std::erase_if(failures, is_its);
    for (Failure& failure : failures) {
      failure.lost = failure.worker == worker.hello.name ? 0 : failure.lost;
    }
  }
}

void Coordinator::expire_leases(Time now) {
  for (const JobId id : open_jobs_) {
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
  note_failure(now, *job, {*range, worker->hello.name, m.reason});
}

/// A job of which nobody can trace the same cells, or any, is at fault itself.
void Coordinator::note_failure(Time now, Job& job, Failure failure) {
  warnings_.warn(
      now, fmt::format("job {}: worker '{}' could not trace cells [{}, {}): {}", job.record.id,
                       failure.worker, failure.range.begin, failure.range.end, failure.reason));
  job.work->failures.push_back(failure);
  note(job, fmt::format("worker '{}' could not trace a part: {}", failure.worker, failure.reason));
  std::map<std::string, std::uint32_t> times;
  const std::vector<Failure>& all = job.work->failures;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const CellRange& range = all[i].range;
    const bool same = range.begin < failure.range.end && failure.range.begin < range.end;
    // Workers are lost together where a network is: other cells say nothing against the job then.
    if (same || (i >= job.work->old_failures && all[i].lost == 0)) {
      ++times[all[i].worker];
    }
  }
  const bool everybody_twice =
      workers_.usable() > 0 &&
      std::all_of(workers_.begin(), workers_.end(), [&](const auto& worker) {
        const auto found = times.find(worker.second.hello.name);
        return !worker.second.may_trace() || (found != times.end() && found->second >= 2);
      });
  const std::uint32_t most =
      job.record.max_failures > 0 ? job.record.max_failures : options_.max_failures;
  if (times.size() >= most || everybody_twice) {
    fail_job(job, fmt::format("{} (so failed {} worker{}, the last '{}')", failure.reason,
                              times.size(), times.size() == 1 ? ", twice" : "s", failure.worker));
  }
}

}  // namespace parray
