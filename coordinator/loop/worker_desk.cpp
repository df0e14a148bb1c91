#include "coordinator/loop/worker_desk.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <vector>

#include "common/base/divide_up.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"

namespace parray::coordinator {

// Limits of PROTOCOL.md.
static constexpr Time longest_heartbeat = seconds(60);
static constexpr Time longest_silence = seconds(600);

/// Returns why the coordinator refuses a worker. Empty: it accepts the worker.
std::string WorkerDesk::refusal_of(const msg::Hello& hello) const {
  const auto other_release = [](const char* what, std::uint32_t theirs, std::uint32_t ours) {
    return fmt::format(
        "{} version {}, but this coordinator uses {}: install the same release on both", what,
        theirs, ours);
  };
  if (hello.version != protocol_version) {
    return other_release("protocol", hello.version, protocol_version);
  }
  if (hello.trace != trace_version) return other_release("trace", hello.trace, trace_version);
  if (hello.fingerprint != farm_.options.fingerprint) {
    return "the worker's built-in test picture differs from the coordinator's: build both from the "
           "same sources, without fast-math, or test the memory of the worker's machine";
  }
  return {};
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::Hello& m) {
  if (released_) return;
  std::string refusal = refusal_of(m);
  WorkerRecord* known = farm_.workers.at(peer);
  if (refusal.empty() && known != nullptr && known->hello.instance != m.instance) {
    lose_worker(now, peer, "it restarted", true);
    known = nullptr;
  }
  if (refusal.empty() && known == nullptr && farm_.workers.size() >= farm_.options.max_workers) {
    refusal = "this coordinator already has " + std::to_string(farm_.options.max_workers) +
              " workers: raise --max-workers";
  }
  if (!refusal.empty()) {
    farm_.warnings.warn(now, "refused worker '" + m.name + "': " + refusal);
    farm_.send(peer, msg::Refuse{refusal});
    return;
  }
  if (known == nullptr) {
    known = &farm_.workers.add(now, peer, m, farm_.sender);
    leases_.check_losses(now, *known);
    disputes_.note_joined(*known);
    leases_.hold_back(now);
    farm_.grants_due = true;
    farm_.watch.note_joined(m.name);
    const std::string joined =
        fmt::format("joined with {} thread{}", m.threads, m.threads == 1 ? "" : "s");
    farm_.announce(FarmEventKind::joined, m.name, joined);
    farm_.arrivals.info(now, fmt::format("worker {} '{}' {}", known->id, m.name, joined));
  }
  known->last_heard = now;
  welcome(*known);
}

/// Returns the factor by which heartbeats and silences are longer than on a small farm: 1 or more.
unsigned WorkerDesk::pace() const {
  const Time longest = std::min(farm_.options.lease_timeout / 3, longest_heartbeat);
  const auto most =
      static_cast<std::size_t>(std::max<Time::rep>(1, longest / farm_.options.heartbeat));
  const std::size_t wanted = divide_up(farm_.workers.size(), farm_.options.heartbeat_workers);
  return static_cast<unsigned>(std::clamp(wanted, std::size_t{1}, most));
}

void WorkerDesk::welcome(WorkerRecord& worker) {
  const auto ms = [](Time t) {
    return static_cast<std::uint32_t>(std::chrono::duration_cast<milliseconds>(t).count());
  };
  worker.pace = pace();
  const Time silence = std::min(worker.pace * farm_.options.silence, longest_silence);
  worker.silence = std::max(worker.silence, silence);
  farm_.send(worker.peer, msg::Welcome{ms(worker.pace * farm_.options.heartbeat), ms(silence)});
}

WorkerRecord* WorkerDesk::heard_from(Time now, const PeerId& peer) {
  WorkerRecord* worker = farm_.workers.at(peer);
  if (worker == nullptr) {
    if (!released_) farm_.send(peer, msg::Identify{});
  } else {
    worker->last_heard = now;
    worker->ours = worker->ours && farm_.sender.ours;
  }
  return worker;
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::Heartbeat& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) return;
  note_progress(now, *worker, m);
  const Time deadline = worker->traced_at + farm_.options.lease_timeout;
  for (const auto& [job_id, epoch] : m.epochs) {
    Job* job = farm_.job_of(job_id);
    const bool held = job != nullptr && job->work && job->work->leases &&
                      job->work->leases->extend(worker->id, epoch, deadline);
    if (!held) {
      farm_.send(peer, msg::Revoke{job_id, epoch});  // the worker no longer holds this lease
    }
  }
  if (!m.epochs.empty() && (!worker->tracing || worker->tracing->first != m.epochs.front().first)) {
    worker->tracing_since = now;
  }
  worker->tracing = m.epochs.empty() ? std::nullopt : std::optional(m.epochs.front());
  worker->load = m.load;
  if (worker->pace == pace()) {
    farm_.send(peer, msg::HeartbeatAck{});
  } else {
    welcome(*worker);
  }
}

/// Notes when a worker last made progress: its number of traced samples changed, or it prepares a
/// job and has not taken too long.
void WorkerDesk::note_progress(Time now, WorkerRecord& worker,
                               const msg::Heartbeat& heartbeat) const {
  worker.preparing_since = heartbeat.preparing ? std::min(worker.preparing_since, now) : never;
  constexpr int longest_preparation = 30;  // lease timeouts
  const bool preparing =
      heartbeat.preparing &&
      now - worker.preparing_since < longest_preparation * farm_.options.lease_timeout;
  if (heartbeat.traced != worker.traced || preparing) {
    worker.traced = heartbeat.traced;
    worker.traced_at = now;
  }
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::Bye& m) {
  lose_worker(now, peer, m.reason, false);
}

void WorkerDesk::note_storage(Time now) {
  const std::string blocked = farm_.job_thread.blocked();
  if (blocked != farm_.storage) {
    farm_.storage = blocked;
    farm_.grants_due = true;
    blocked.empty() ? farm_.log->info("the store can commit again: jobs continue")
                    : farm_.log->error("jobs wait: {}", blocked);
  }
  blocked_since_ = blocked.empty() ? never : std::min(blocked_since_, now);
  released_ = released_ && !blocked.empty();
  if (!released_ && blocked_since_ != never && farm_.options.release_after != never &&
      now - blocked_since_ > farm_.options.release_after) {
    release_workers(now);
  }
  for (const JobId id : std::vector<JobId>(farm_.at_work.begin(), farm_.at_work.end())) {
    Job& job = farm_.jobs.at(id);
    if (job.retry_at <= now) {
      job.retry_at = never;
      job_book_.finish_job(job);
    }
  }
}

/// Sends all workers away, so that they try the standby, which may serve by now. A worker that
/// returns gets no answer until the store can commit again, and therefore tries the next address.
void WorkerDesk::release_workers(Time now) {
  released_ = true;
  std::vector<PeerId> peers;
  for (const auto& [peer, worker] : farm_.workers) peers.push_back(peer);
  farm_.log->warn("the store could not commit for {} s: told {} workers to try another coordinator",
                  to_seconds(farm_.options.release_after), peers.size());
  for (const PeerId& peer : peers) {
    farm_.send(peer, msg::Bye{"this coordinator cannot store results now"});
    lose_worker(now, peer, "sent away because the store cannot commit", false);
  }
}

void WorkerDesk::lose_worker(Time now, const PeerId& peer, const std::string& why, bool failed) {
  const WorkerRecord* found = farm_.workers.at(peer);
  if (found == nullptr) return;
  const WorkerRecord worker = *found;
  farm_.workers.remove(peer);
  farm_.scenes.forget_worker(worker.id);
  farm_.grants_due = true;
  farm_.tally.lost += failed ? 1 : 0;
  if (failed) farm_.machines.note_lost(worker.machine_key, now);
  farm_.announce(failed ? FarmEventKind::lost : FarmEventKind::left, worker.hello.name, why);
  farm_.watch.note_left(
      {now, worker.hello.name, worker.hello.host, text_of(worker.machine), why, failed});
  const auto has_same_name = [&](const auto& other) {
    return other.second.hello.name == worker.hello.name;
  };
  const bool restarted =
      worker.tracing.has_value() && std::ranges::any_of(farm_.workers, has_same_name);
  std::size_t leases = 0;
  for (const JobId id : std::vector<JobId>(farm_.at_work.begin(), farm_.at_work.end())) {
    Job& job = farm_.jobs.at(id);
    if (!job.work || !job.work->leases) continue;
    for (const Lease& lease : job.work->leases->drop_worker(worker.id)) {
      ++leases;
      if (failed && worker.tracing == std::pair(id, lease.epoch)) {
        leases_.note_failure(now, job,
                             {lease.range, worker.machine, worker.key, worker.hello.name,
                              "a worker was lost while it traced this: " + why, true, !restarted});
      }
      if (!job.work) {
        break;  // this failure ended the job
      }
    }
    if (job.tracing()) job_book_.end_pass_if_done(job);
  }
  farm_.arrivals.info(now, fmt::format("worker {} '{}' left ({}); its {} leases are free again",
                                       worker.id, worker.hello.name, why, leases));
}

/// Finds a scene by its SHA-256 among the jobs at work. Null: no job at work has it.
const ScenePayload* WorkerDesk::scene_at_work(const std::string& scene) const {
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.work && job.record.scene == scene && job.work->plan) return &job.work->scene;
  }
  return nullptr;
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::NeedScene& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) return;
  const ScenePayload* scene = scene_at_work(m.scene);
  if (scene == nullptr) return;
  const Bulk* bytes = scene->held_bytes();
  if (bytes == nullptr) {  // the worker is in this process
    farm_.send(peer, msg::SceneSource{m.scene, {}, "", "", scene->scene()});
    return;
  }
  farm_.send(peer, farm_.scenes.source_for(*worker, m.scene, bytes->data.size(), m.failed));
  const WorkerRecord* source = farm_.workers.by_id(farm_.scenes.source_of(worker->id, m.scene));
  farm_.log->debug("scene {:.8} for worker {} '{}': from {}{}", m.scene, worker->id,
                   worker->hello.name, source == nullptr ? "the coordinator" : source->hello.name,
                   m.failed > 0 ? fmt::format(", attempt {}", m.failed + 1) : "");
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::NeedChunk& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) return;
  const ScenePayload* scene = scene_at_work(m.scene);
  const Bulk* bytes = scene == nullptr ? nullptr : scene->held_bytes();
  auto chunk = bytes == nullptr ? std::nullopt : farm_.scenes.chunk(m.scene, bytes->data, m.chunk);
  if (chunk) {
    farm_.send(peer, std::move(*chunk));
  } else {
    farm_.send(peer, msg::NoScene{m.scene});
  }
}

void WorkerDesk::forget_scene(const std::string& scene) {
  if (scene_at_work(scene) != nullptr) return;
  const SceneService::Spread spread = farm_.scenes.forget_scene(scene);
  if (spread.workers > 0) {
    farm_.log->debug("{1} workers requested scene {0:.8}; the coordinator sent {2} bytes", scene,
                     spread.workers, spread.bytes);
  }
}

}  // namespace parray::coordinator
