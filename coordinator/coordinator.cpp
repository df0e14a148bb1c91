#include "coordinator/coordinator.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

namespace parray {

Coordinator::Coordinator(CoordinatorOptions options, Store& store,
                         std::shared_ptr<spdlog::logger> log)
    : options_(std::move(options)), store_(store), log_(std::move(log)) {
  restore_jobs();
}

template <typename Other>
void Coordinator::on(Time /*now*/, const PeerId& /*peer*/, Other& /*m*/) {
  ++tally_.malformed;
  log_->warn("message that a coordinator does not take: dropped");
}

void Coordinator::receive(Time now, Delivery delivery) {
  try {
    Message message = decode(delivery.frames);
    std::visit([&](auto& m) { on(now, delivery.peer, m); }, message);
  } catch (const ProtocolError& error) {
    ++tally_.malformed;
    log_->warn("malformed message dropped: {}", error.what());
    if (error.request()) {
      fail_request(delivery.peer, *error.request(), 2, error.what());
    }
  }
}

Time Coordinator::tick(Time now) {
  finish_complete_jobs(now);
  std::vector<PeerId> lost;
  Time next = never;
  for (const auto& [peer, worker] : workers_) {
    if (worker.last_heard + options_.silence <= now) {
      lost.push_back(peer);
    } else {
      next = std::min(next, worker.last_heard + options_.silence);
    }
  }
  for (const PeerId& peer : lost) {
    lose_worker(peer, "silent for too long");
  }
  expire_leases(now);
  grant_leases(now);
  for (Job* job : open_jobs_) {
    next = std::min(next, job->work->leases.next_deadline());
  }
  return next;
}

std::vector<Delivery> Coordinator::take_outbox() {
  if (store_dirty_) {
    store_.commit();  // nothing is acknowledged before it is kept
    store_dirty_ = false;
  }
  return std::exchange(outbox_, {});
}

void Coordinator::leave(const std::string& reason) {
  for (const auto& [peer, worker] : workers_) {
    send(peer, msg::Bye{reason});
  }
}

void Coordinator::send(const PeerId& peer, const Message& message) {
  outbox_.push_back({peer, encode(message)});
}

Coordinator::WorkerRecord* Coordinator::worker_at(const PeerId& peer) {
  const auto found = workers_.find(peer);
  return found == workers_.end() ? nullptr : &found->second;
}

void Coordinator::on(Time now, const PeerId& peer, msg::Hello& m) {
  const auto refuse = [&](const std::string& reason) {
    log_->warn("worker '{}' refused: {}", m.name, reason);
    send(peer, msg::Refuse{reason});
  };
  if (m.version != protocol_version) {
    refuse("protocol version " + std::to_string(m.version) + ", but this coordinator speaks " +
           std::to_string(protocol_version) + ": install the same release on both");
    return;
  }
  if (m.trace != trace_version) {
    refuse("trace version " + std::to_string(m.trace) +
           ", but this coordinator's pictures are of " + std::to_string(trace_version) +
           ": install the same release on both");
    return;
  }
  if (m.fingerprint != options_.fingerprint) {
    refuse(
        "it traces other bits than this coordinator (the built-in test picture differs): build "
        "both from the same sources, without fast-math, or test that machine's memory");
    return;
  }
  WorkerRecord* known = worker_at(peer);
  if (known != nullptr && known->hello.instance != m.instance) {
    lose_worker(peer, "started again");
    known = nullptr;
  }
  if (known == nullptr) {
    if (workers_.size() >= options_.max_workers) {
      refuse("this coordinator has its " + std::to_string(options_.max_workers) +
             " workers: raise --max-workers");
      return;
    }
    WorkerRecord record;
    record.id = next_worker_++;
    record.peer = peer;
    record.hello = m;
    record.traced_at = now;
    known = &workers_.emplace(peer, std::move(record)).first->second;
    log_->info("worker {} '{}' joined with {} threads", known->id, m.name, m.threads);
  }
  known->last_heard = now;
  const auto ms = [](Time t) {
    return static_cast<std::uint32_t>(std::chrono::duration_cast<milliseconds>(t).count());
  };
  send(peer, msg::Welcome{ms(options_.heartbeat), ms(options_.silence)});
}

void Coordinator::on(Time now, const PeerId& peer, msg::Heartbeat& m) {
  WorkerRecord* worker = worker_at(peer);
  if (worker == nullptr) {
    send(peer, msg::Who{});
    return;
  }
  worker->last_heard = now;
  note_progress(now, *worker, m);
  for (const auto& [job_id, epoch] : m.epochs) {
    Job* job = job_of(job_id);
    const Time deadline = worker->traced_at + options_.lease_timeout;
    if (job == nullptr || !job->open() || !job->work->leases.extend(worker->id, epoch, deadline)) {
      send(peer, msg::Revoke{job_id, epoch});  // it works on what is no longer its own
    }
  }
  send(peer, msg::Pulse{});
}

/// A worker is at work while the samples that it has traced grow, and while it prepares, within
/// reason.
void Coordinator::note_progress(Time now, WorkerRecord& worker, const msg::Heartbeat& heartbeat) {
  worker.preparing_since = heartbeat.preparing ? std::min(worker.preparing_since, now) : never;
  constexpr int longest_preparation = 30;  // lease timeouts
  const bool preparing = heartbeat.preparing && now - worker.preparing_since <
                                                    longest_preparation * options_.lease_timeout;
  if (heartbeat.traced != worker.traced || preparing) {
    worker.traced = heartbeat.traced;
    worker.traced_at = now;
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::NeedScene& m) {
  WorkerRecord* worker = worker_at(peer);
  if (worker == nullptr) {
    send(peer, msg::Who{});
    return;
  }
  worker->last_heard = now;
  if (worker->scene_sent == m.scene && now < worker->scene_again_at) {
    return;  // on its way
  }
  for (const auto& [id, job] : jobs_) {
    if (job.open() && job.record.scene == m.scene) {
      const std::chrono::duration<double> transfer(
          static_cast<double>(job.work->scene_bytes->size()) / 1e7);
      worker->scene_sent = m.scene;
      log_->debug("scene sent to worker {} '{}': {} bytes", worker->id, worker->hello.name,
                  job.work->scene_bytes->size());
      worker->scene_again_at =
          now + options_.heartbeat + std::chrono::duration_cast<Time>(transfer);
      send(peer, msg::SceneData{m.scene, *job.work->scene_bytes});
      return;
    }
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::Result& m) {
  WorkerRecord* worker = worker_at(peer);
  if (worker == nullptr) {
    send(peer, msg::Who{});  // it repeats the result once it is known
    return;
  }
  worker->last_heard = now;
  Job* job = job_of(m.job);
  if (job == nullptr || !job->open() || worker->quarantined) {
    ++tally_.stale;
    send(peer, msg::VerdictOf{m.job, m.epoch, msg::Verdict::stale});
    return;
  }
  merge_result(now, *worker, *job, m);
}

void Coordinator::merge_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result) {
  const std::string bytes = row_block_to_bytes(result.block);
  JobWork& work = *job.work;
  const auto leased = work.leases.leased_rect(result.epoch);
  const bool fits =
      result.block.width == job.record.settings.width &&
      (!leased || work.framebuffer.sample_count(*leased) == result.block.counts.samples);
  const auto completion =
      fits ? work.leases.complete(worker.id, result.epoch, result.block.rect, digest_of(bytes))
           : LeaseTable::Completion{};
  send(worker.peer, msg::VerdictOf{result.job, result.epoch, completion.verdict});
  switch (completion.verdict) {
    case msg::Verdict::stale:
      ++tally_.stale;
      log_->warn("job {} lease {}: late result of worker {} '{}' refused", result.job, result.epoch,
                 worker.id, worker.hello.name);
      return;
    case msg::Verdict::duplicate:
      ++tally_.duplicate;
      return;
    case msg::Verdict::mismatch:
      ++tally_.mismatch;
      quarantine(worker);
      log_->error(
          "job {} lease {}: worker {} '{}' returned other bits than another worker did for "
          "the same samples; it gets no more leases: test both machines",
          result.job, result.epoch, worker.id, worker.hello.name);
      return;
    case msg::Verdict::accepted:
      break;
  }
  ++tally_.accepted;
  ++worker.accepted;
  log_->debug("job {} lease {} accepted from worker {} '{}'", result.job, result.epoch, worker.id,
              worker.hello.name);
  work.framebuffer.merge(result.block);
  store_.put_block(job.record.id, result.epoch, bytes);
  store_dirty_ = true;
  if (result.seconds > 0) {
    const double speed = static_cast<double>(result.block.counts.samples) / result.seconds;
    worker.samples_per_second =
        worker.samples_per_second > 0 ? (worker.samples_per_second + speed) / 2 : speed;
  }
  if (work.contributors.insert(worker.id).second) {
    work.contributor_threads += worker.hello.threads;
  }
  work.build_seconds = std::max(work.build_seconds, result.build_seconds);
  work.accelerator_bytes = std::max(work.accelerator_bytes, result.accelerator_bytes);
  work.isa = result.isa;
  for (const WorkerId other : completion.others) {
    for (const auto& [peer, record] : workers_) {
      if (record.id == other) {
        send(peer, msg::Revoke{result.job, result.epoch});
      }
    }
  }
  if (work.leases.done()) {
    if (job.next_pass(now)) {
      store_.put_job(job.record);
    } else {
      finish_job(now, job);
    }
  }
}

/// No more leases, and none of its results counts any more.
void Coordinator::quarantine(WorkerRecord& worker) {
  worker.quarantined = true;
  for (Job* job : open_jobs_) {
    job->work->leases.drop_worker(worker.id);
  }
}

void Coordinator::on(Time /*now*/, const PeerId& peer, msg::Bye& m) { lose_worker(peer, m.reason); }

void Coordinator::lose_worker(const PeerId& peer, const std::string& why) {
  const WorkerRecord* worker = worker_at(peer);
  if (worker == nullptr) {
    return;
  }
  std::size_t leases = 0;
  for (Job* job : open_jobs_) {
    leases += job->work->leases.drop_worker(worker->id).size();
  }
  log_->info("worker {} '{}' left ({}); {} of its leases go to others", worker->id,
             worker->hello.name, why, leases);
  workers_.erase(peer);
}

void Coordinator::expire_leases(Time now) {
  for (Job* job : open_jobs_) {
    for (const auto& expired : job->work->leases.expire(now)) {
      log_->warn("job {} lease {}: worker {} made no progress in time; the lease goes to another",
                 job->record.id, expired.epoch, expired.worker);
    }
  }
}

/// Speeds of all workers. One that is not measured yet counts as fast, a thread, as those that are;
/// as 1 a thread if none is.
Coordinator::FarmSpeed Coordinator::farm_speed() const {
  double measured = 0;
  double measured_threads = 0;
  double other_threads = 0;
  for (const auto& [peer, worker] : workers_) {
    if (worker.samples_per_second > 0) {
      measured += worker.samples_per_second;
      measured_threads += worker.hello.threads;
    } else {
      other_threads += worker.hello.threads;
    }
  }
  const double per_thread = measured_threads > 0 ? measured / measured_threads : 1;
  return {per_thread, measured + per_thread * other_threads};
}

Asker Coordinator::asker_for(const WorkerRecord& worker, const Job& job,
                             const FarmSpeed& farm) const {
  Asker asker;
  asker.worker = worker.id;
  asker.threads = worker.hello.threads;
  asker.workers = static_cast<std::uint32_t>(workers_.size());
  const double speed = worker.samples_per_second;
  asker.share = (speed > 0 ? speed : farm.per_thread * worker.hello.threads) / farm.all;
  const double unit_samples = job.record.settings.width * job.work->leases.density();
  // A first lease only measures: about 50 ms on a core of 2 M samples/s.
  constexpr double first_lease_samples = 1e5;
  const double most = speed > 0 ? speed * to_seconds(options_.longest_lease)
                                : first_lease_samples * worker.hello.threads;
  const double least = speed * to_seconds(options_.shortest_lease);
  asker.most_units = static_cast<std::uint64_t>(std::max(most / unit_samples, 1.0));
  asker.least_units = static_cast<std::uint64_t>(std::max(least / unit_samples, 1.0));
  return asker;
}

/// Leases to every worker with room, one at a time in turn, so that the first to be asked does not
/// take all.
void Coordinator::grant_leases(Time now) {
  const FarmSpeed farm = farm_speed();
  bool granted = true;
  while (granted) {
    granted = false;
    for (auto& [peer, worker] : workers_) {
      granted = (!worker.quarantined && grant_one(now, worker, farm)) || granted;
    }
  }
}

/// Pending work first, by the jobs' order. A copy of somebody else's lease only for a worker with
/// nothing else to do, and only when no job has pending work.
bool Coordinator::grant_one(Time now, WorkerRecord& worker, const FarmSpeed& farm) {
  std::size_t held = 0;
  Job* with_pending = nullptr;
  for (Job* job : open_jobs_) {
    held += job->work->leases.held_by(worker.id);
    if (with_pending == nullptr && job->work->leases.has_pending()) {
      with_pending = job;
    }
  }
  if (held >= worker.hello.capacity) {
    return false;
  }
  if (with_pending != nullptr) {
    return grant_from(now, worker, *with_pending, farm, false);
  }
  return held == 0 && std::any_of(open_jobs_.begin(), open_jobs_.end(), [&](Job* job) {
           return grant_from(now, worker, *job, farm, true);
         });
}

bool Coordinator::grant_from(Time now, WorkerRecord& worker, Job& job, const FarmSpeed& farm,
                             bool may_copy) {
  const auto lease =
      job.work->leases.grant(now + options_.lease_timeout, asker_for(worker, job, farm), may_copy);
  if (!lease) {
    return false;
  }
  if (job.record.state == JobState::queued) {
    job.record.state = JobState::running;
    job.work->started = now;
    job.work->pass_began = now;
  }
  ++tally_.granted;
  log_->debug("job {} lease {} to worker {} '{}': rows [{}, {}) samples [{}, {}){}", job.record.id,
              lease->epoch, worker.id, worker.hello.name, lease->rect.row_begin,
              lease->rect.row_end, lease->rect.sample_begin, lease->rect.sample_end,
              lease->copy ? ", a copy" : "");
  send(worker.peer, msg::Grant{job.record.id, lease->epoch, lease->rect, job.record.scene,
                               job.record.settings, job.work->framebuffer.samples_of(lease->rect)});
  return true;
}

}  // namespace parray
