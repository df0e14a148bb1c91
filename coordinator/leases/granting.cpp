// Who gets which leases, and which jobs get memory.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {
namespace {

/// What waits for the backroom stays within memory: beyond this many errands nothing is granted.
constexpr std::size_t most_backlog = 4096;
/// Some milliseconds' worth: whoever asks something meanwhile is answered soon.
constexpr int most_granted_at_once = 64;

}  // namespace

/// Leases to every worker with room, one at a time in turn, so that the first to be asked does not
/// take all. Does nothing where nothing has changed since. False: there are more to be granted than
/// one turn of the loop has time for.
bool Coordinator::grant_leases(Time now) {
  if (!grants_due_ || !storage_.empty() || backroom_.backlog() > most_backlog) {
    return true;
  }
  if (workers_.size() == 0) {
    return true;  // the first to come changes that
  }
  if (queue_again_at_ <= now) {
    queue_open_jobs();
  }
  int granted = 0;
  bool room = true;
  auto next = workers_.after(granted_last_);
  for (std::size_t in_vain = 0; in_vain < workers_.size() && !index_.open().empty();) {
    if (granted == most_granted_at_once) {
      return false;
    }
    next = next == workers_.end() ? workers_.begin() : next;
    WorkerRecord& worker = (next++)->second;
    const bool got = worker.has_room() && grant_one(now, worker, room);
    if (got) {
      granted_last_ = worker.peer;
      ++granted;
    }
    in_vain = got ? 0 : in_vain + 1;
  }
  grants_due_ = false;
  return true;
}

/// Pending work first, of whose turn it is; a job that holds no memory yet gets it when its turn
/// comes and there is `room`. A copy of somebody else's lease only for a worker with nothing else
/// to do. Thousands of jobs may wait for memory: they cost no look at the job.
bool Coordinator::grant_one(Time now, WorkerRecord& worker, bool& room) {
  using Answer = FairQueue::Answer;
  const auto offer_work = [&](JobId id) {
    if (!room && !at_work_.contains(id)) {
      return Answer::nothing;
    }
    Job& job = jobs_.at(id);
    if (room && job.phase == JobPhase::waiting && job.record.state != JobState::paused) {
      room = make_room(memory_of(job));
      if (room) {
        prepare(now, job);
      }
    }
    if (may_trace(now, worker, job) && grant_from(now, worker, job, false)) {
      return Answer::granted;
    }
    return job.phase == JobPhase::preparing ? Answer::wait : Answer::nothing;
  };
  const auto offer_copy = [&](JobId id) {
    if (!at_work_.contains(id)) {
      return Answer::nothing;
    }
    Job& job = jobs_.at(id);
    const bool granted = may_trace(now, worker, job) && grant_from(now, worker, job, true);
    return granted ? Answer::granted : Answer::nothing;
  };
  return queue_.visit(offer_work) || (worker.held == 0 && queue_.visit(offer_copy));
}

bool Coordinator::may_trace(Time now, const WorkerRecord& worker, const Job& job) {
  if (!job.tracing() || job.record.state == JobState::paused) {
    return false;
  }
  if (!job.pause_reason.empty()) {
    return false;
  }
  const auto shunned = worker.shunned.find(job.record.id);
  return shunned == worker.shunned.end() || now >= shunned->second;
}

bool Coordinator::grant_from(Time now, WorkerRecord& worker, Job& job, bool copy) {
  LeaseTable& leases = *job.work->leases;
  const Time deadline = now + options_.lease_timeout;
  const auto lease =
      copy ? leases.grant_copy(deadline, worker.id)
           : leases.grant(deadline, worker.id, {worker.hello.threads, worker.samples_per_second},
                          workers_.speed(), worker.machine_key);
  if (!lease) {
    return false;
  }
  if (job.work->started == never) {
    job.work->started = now;
    job.work->clock_began = options_.waiting_counts && job.submitted != never ? job.submitted : now;
    job.work->pass_began = now;
    note(job, "begun");
  }
  if (job.record.state == JobState::queued) {
    job.record.state = JobState::running;
  }
  ++tally_.granted;
  ++worker.held;
  const double samples = job.work->plan->cell_samples() * static_cast<double>(lease->range.count());
  const double expected = samples * (job.work->price > 0 ? job.work->price : price_);
  worker.note_grant({job.record.id, lease->epoch, now, expected});
  job.granted = now;
  if (queue_.granted_by_turn()) {
    job.served = now;
  }
  queue_.charge(expected);
  send_grant(now, worker, job, *lease);
  return true;
}

void Coordinator::send_grant(Time /*now*/, WorkerRecord& worker, Job& job, const Lease& lease) {
  log_->debug("job {} lease {} to worker {} '{}': pass {} cells [{}, {})", job.record.id,
              lease_number(lease.epoch), worker.id, worker.hello.name, job.work->pass,
              lease.range.begin, lease.range.end);
  // Its cells may cost far more than those by which its length was chosen.
  const double longest = lease.divisible ? 2 * options_.lease_length.longest : 0;
  send(worker.peer,
       msg::Grant{job.record.id, job.work->pass, lease.epoch, job.work->plan->batch(lease.range),
                  job.record.scene, job.record.settings, longest});
}

std::uint64_t Coordinator::memory_of(const Job& job) const {
  return JobPicture::memory(job.record.settings) + (store_ != nullptr ? job.record.scene_bytes : 0);
}

std::uint64_t Coordinator::memory_in_use() const {
  std::uint64_t bytes = desk_.memory() + bulk_.bytes() + scenes_waiting_.bytes();
  for (const JobId id : at_work_) {
    bytes += memory_of(jobs_.at(id));
  }
  if (store_ == nullptr) {
    for (const auto& [id, job] : jobs_) {
      bytes += job.scene.size() + job.picture_bytes;
    }
  }
  return bytes;
}

/// Whether each job that waits has room beside the scenes of all, with one more that needs so much,
/// a scene of so many bytes included: else nobody's turn would come.
bool Coordinator::fits_beside_scenes(std::uint64_t needed, std::uint64_t scene) const {
  std::uint64_t scenes = scene;
  std::uint64_t largest = needed - scene;
  for (const JobId id : index_.open()) {
    scenes += jobs_.at(id).scene.size();
    largest = std::max(largest, JobPicture::memory(jobs_.at(id).record.settings));
  }
  return scenes + largest <= options_.memory;
}

/// What an unfinished job lacks, for people; empty: nothing.
std::string Coordinator::waits_for(const Job& job) const {
  if (job.ended() || job.record.state == JobState::paused) {
    return {};
  }
  if (!storage_.empty()) {
    return storage_;
  }
  if (job.phase == JobPhase::finishing || job.phase == JobPhase::preparing) {
    return {};
  }
  if (workers_.usable() == 0) {
    const bool held_back =
        std::ranges::any_of(workers_, [](const auto& w) { return w.second.held_back; });
    return workers_.size() == 0     ? "no workers connected"
           : workers_.all_drained() ? "all workers are drained (parray workers readmit NAME)"
           : held_back ? "all workers failed where others succeeded and wait (parray workers)"
                       : "no worker whose results can be trusted";
  }
  if (job.phase == JobPhase::waiting && memory_in_use() + memory_of(job) > options_.memory) {
    return "memory: other jobs are being rendered";
  }
  return job.work ? desk_.wait(now_, job.work->generation) : "";
}

/// A full disk holds all jobs until there is room; then they go on by themselves.
void Coordinator::note_storage(Time now) {
  const std::string blocked = backroom_.blocked();
  if (blocked != storage_) {
    storage_ = blocked;
    grants_due_ = true;
    blocked.empty() ? log_->info("everything can be kept again: jobs go on")
                    : log_->error("jobs wait: {}", blocked);
  }
  blocked_since_ = blocked.empty() ? never : std::min(blocked_since_, now);
  released_ = released_ && !blocked.empty();
  if (!released_ && blocked_since_ != never && options_.release_after != never &&
      now - blocked_since_ > options_.release_after) {
    release_workers(now);
  }
  for (const JobId id : std::vector<JobId>(at_work_.begin(), at_work_.end())) {
    Job& job = jobs_.at(id);
    if (job.retry_at <= now) {
      job.retry_at = never;
      finish_job(job);
    }
  }
}

/// Says goodbye to all workers, so that they try the standby, which may serve by now. A worker that
/// comes back gets no answer until the store can commit again, and so leaves this address.
void Coordinator::release_workers(Time now) {
  released_ = true;
  std::vector<PeerId> peers;
  for (const auto& [peer, worker] : workers_) {
    peers.push_back(peer);
  }
  log_->warn("nothing can be kept for {} s: {} workers are sent to another coordinator",
             to_seconds(options_.release_after), peers.size());
  for (const PeerId& peer : peers) {
    send(peer, msg::Bye{"this coordinator cannot keep results now"});
    lose_worker(now, peer, "sent away: nothing can be kept", false);
  }
}

}  // namespace parray::coordinator
