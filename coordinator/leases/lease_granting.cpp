#include <spdlog/spdlog.h>

#include <algorithm>
#include <tuple>

#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"

namespace parray::coordinator {

/// Rebuilds the queue with the current amounts of remaining work. A series counts as one job: its
/// frames stand at the place of its first, with the remaining work of all of them.
void LeaseDesk::queue_open_jobs() {
  std::vector<Job*> open;
  open.reserve(farm_.index.open().size());
  for (const JobId id : farm_.index.open()) {
    Job& job = farm_.jobs.at(id);
    if (farm_.now > Time(0) && (job.served == never || job.record.state == JobState::paused)) {
      job.served = job.granted = farm_.now;  // its waiting time begins
    }
    open.push_back(&job);
  }
  std::ranges::sort(open, {}, [](const Job* job) {
    return std::tuple(job->record.listed_as(), job->record.frame, job->record.id);
  });
  std::vector<FairQueue::Entry> entries;
  entries.reserve(open.size());
  for (auto first = open.begin(); first != open.end();) {
    const JobId listed = (*first)->record.listed_as();
    const auto end = std::find_if(
        first, open.end(), [&](const Job* job) { return job->record.listed_as() != listed; });
    bool fresh = true;
    double work_left = 0;
    for (auto job = first; job != end; ++job) {
      const auto& work = (*job)->work;
      fresh =
          fresh && (!work || work->started == never) && (*job)->record.state != JobState::paused;
      work_left +=
          (*job)->samples_left(farm_.now) * (work && work->price > 0 ? work->price : farm_.price);
    }
    for (; first != end; ++first) {
      const Job& job = **first;
      entries.push_back({job.record.id, job.record.user, job.record.share, job.record.priority,
                         fresh, work_left,
                         to_seconds(farm_.now - job.served) >= FairQueue::starving_after,
                         to_seconds(farm_.now - job.granted)});
    }
  }
  queue_.assign(entries);
  farm_.queue_again_at = farm_.now + milliseconds(100);
  farm_.grants_due = true;
}

/// If more tasks than this wait for the job thread, no leases are granted, to limit memory.
static constexpr std::size_t most_backlog = 4096;
/// Grants per turn. They take some milliseconds, so that other messages do not wait long.
static constexpr int most_granted_at_once = 64;

bool LeaseDesk::grant_leases(Time now) {
  if (!farm_.grants_due || !farm_.storage.empty() || farm_.job_thread.backlog() > most_backlog) {
    return true;
  }
  if (farm_.workers.size() == 0) {
    return true;  // a worker that joins sets grants_due
  }
  if (farm_.queue_again_at <= now) queue_open_jobs();
  int granted = 0;
  bool room = true;
  auto next = farm_.workers.after(granted_last_);
  for (std::size_t refusals = 0; refusals < farm_.workers.size() && !farm_.index.open().empty();) {
    if (granted == most_granted_at_once) return false;
    next = next == farm_.workers.end() ? farm_.workers.begin() : next;
    WorkerRecord& worker = (next++)->second;
    const bool got = worker.has_room() && grant_one(now, worker, room);
    if (got) {
      granted_last_ = worker.peer;
      ++granted;
    }
    refusals = got ? 0 : refusals + 1;
  }
  farm_.grants_due = false;
  return true;
}

/// Grants pending work of the job whose turn it is. If that job has no memory yet, prepares it if
/// there is `room`. Grants a copy of another worker's lease only to an idle worker. Does not look
/// at jobs that wait for memory, because there may be thousands.
bool LeaseDesk::grant_one(Time now, WorkerRecord& worker, bool& room) {
  using Answer = FairQueue::Answer;
  const auto offer_work = [&](JobId id) {
    if (!room && !farm_.at_work.contains(id)) return Answer::nothing;
    Job& job = farm_.jobs.at(id);
    if (room && job.phase == JobPhase::waiting && job.record.state != JobState::paused) {
      const std::uint64_t needed = job_book_.memory_of(job);
      if (needed > farm_.options.memory) {
        return Answer::nothing;  // an earlier coordinator had more: other jobs need not wait
      }
      room = job_book_.make_room(needed);
      if (room) job_book_.prepare(job);
    }
    if (may_trace(now, worker, job) && grant_from(now, worker, job, false)) return Answer::granted;
    return job.phase == JobPhase::preparing ? Answer::wait : Answer::nothing;
  };
  const auto offer_copy = [&](JobId id) {
    if (!farm_.at_work.contains(id)) return Answer::nothing;
    Job& job = farm_.jobs.at(id);
    const bool granted = may_trace(now, worker, job) && grant_from(now, worker, job, true);
    return granted ? Answer::granted : Answer::nothing;
  };
  return queue_.visit(offer_work) || (worker.held == 0 && queue_.visit(offer_copy));
}

bool LeaseDesk::may_trace(Time now, const WorkerRecord& worker, const Job& job) {
  if (!job.tracing() || job.record.state == JobState::paused) return false;
  if (!job.pause_reason.empty()) return false;
  const auto denied_jobs = worker.denied_jobs.find(job.record.id);
  return denied_jobs == worker.denied_jobs.end() || now >= denied_jobs->second;
}

bool LeaseDesk::grant_from(Time now, WorkerRecord& worker, Job& job, bool copy) {
  LeaseTable& leases = *job.work->leases;
  const Time deadline = now + farm_.options.lease_timeout;
  const auto lease =
      copy ? leases.grant_copy(deadline, worker.id)
           : leases.grant(deadline, worker.id, {worker.hello.threads, worker.samples_per_second},
                          farm_.workers.speed(), worker.machine_key);
  if (!lease) return false;
  const bool begins = job.work->started == never;
  if (begins) {
    job.work->started = now;
    job.work->clock_began =
        farm_.options.waiting_counts && job.submitted != never ? job.submitted : now;
    job.work->pass_began = now;
    job.work->samples_before = job.work->samples;
    job.work->taken_before = job.record.course.taken;
    const bool again = job.record.course.started > 0;
    job.record.course.started = again ? job.record.course.started : farm_.wall_now();
    job.count_time(now, true);
    farm_.note(job, again ? "continued" : "started");
    farm_.note_begun(job);
  }
  if (job.record.state == JobState::queued) job.record.state = JobState::running;
  if (begins) {
    farm_.keep(job);  // its start
  }
  ++farm_.tally.granted;
  ++worker.held;
  const double samples = job.work->plan->cell_samples() * static_cast<double>(lease->range.count());
  const double expected = samples * (job.work->price > 0 ? job.work->price : farm_.price);
  worker.note_grant({job.record.id, lease->epoch, now, expected});
  job.granted = now;
  if (queue_.granted_by_turn()) job.served = now;
  queue_.charge(expected);
  send_grant(worker, job, *lease);
  return true;
}

void LeaseDesk::send_grant(WorkerRecord& worker, Job& job, const Lease& lease) {
  farm_.log->debug("job {} lease {} to worker {} '{}': pass {} cells [{}, {})", job.record.id,
                   farm_.lease_number(lease.epoch), worker.id, worker.hello.name, job.work->pass,
                   lease.range.begin, lease.range.end);
  // The cells may cost far more than the cells that determined the length of the lease.
  const double longest = lease.divisible ? 2 * farm_.options.lease_length.longest : 0;
  farm_.send(worker.peer, msg::Grant{job.record.id, job.work->pass, lease.epoch,
                                     job.work->plan->batch(lease.range), job.record.scene,
                                     job.record.settings, longest});
}

}  // namespace parray::coordinator
