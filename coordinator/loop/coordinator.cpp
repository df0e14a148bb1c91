// Messages in and out, and who is there.
#include "coordinator/loop/coordinator.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <random>

#include "common/base/divide_up.h"

namespace parray::coordinator {

// The protocol's.
static constexpr Time longest_heartbeat = seconds(60);
static constexpr Time longest_silence = seconds(600);
/// Pictures and journals that one client may have under way.
static constexpr std::size_t most_bulk_of_peer = 4;

/// Numbers that no worker can foresee. Opening the device takes far longer than a number.
static std::function<double()> unforeseeable() {
  return [device = std::make_shared<std::random_device>()] {
    return static_cast<double>((*device)()) * 0x1p-32;
  };
}

Coordinator::Coordinator(CoordinatorOptions options, Store* store,
                         std::shared_ptr<spdlog::logger> log)
    : options_(std::move(options)),
      store_(store),
      log_(log),
      warnings_(log),
      arrivals_(std::move(log), 100),
      checks_(options_.checks, options_.random ? options_.random : unforeseeable()),
      desk_(options_.referee, options_.refereeing),
      requests_(options_.limits.requests),
      bulk_(options_.memory / 4, most_bulk_of_peer),
      scenes_waiting_(options_.memory / 4, SIZE_MAX),
      backroom_(store, options_.backroom) {
  restore_worker_notes();
  restore_jobs();
}

template <typename Other>
void Coordinator::on(Time now, const PeerId& /*peer*/, Other& /*m*/) {
  ++tally_.malformed;
  warnings_.warn(now, "message that a coordinator does not take: dropped");
}

/// What only workers say. Everything else is asked by clients.
static bool is_of_workers(const Message& message) {
  return std::holds_alternative<msg::Hello>(message) ||
         std::holds_alternative<msg::Heartbeat>(message) ||
         std::holds_alternative<msg::NeedScene>(message) ||
         std::holds_alternative<msg::NeedChunk>(message) ||
         std::holds_alternative<msg::Result>(message) ||
         std::holds_alternative<msg::Failed>(message) || std::holds_alternative<msg::Bye>(message);
}

static bool may_say(Role role, const Message& message) {
  switch (role) {
    case Role::any:
      return true;
    case Role::worker:
      return is_of_workers(message);
    case Role::client:
    case Role::admin:
      return !is_of_workers(message);
    case Role::none:
      break;
  }
  return false;
}

/// Of a key that may not say that.
void Coordinator::refuse(Time now, const PeerId& peer, const Message& message) {
  ++tally_.malformed;
  const std::string why =
      sender_.role == Role::none
          ? "its key is no longer allowed"
          : fmt::format("the key '{}' is that of {} {}", sender_.name,
                        sender_.role == Role::admin ? "an" : "a", name_of(sender_.role));
  warnings_.warn(now, "message refused: " + why);
  if (is_of_workers(message)) {
    if (workers_.at(peer) != nullptr) {
      lose_worker(now, peer, why, false);
    }
    send(peer, msg::Bye{why});  // it may have been welcome before
    send(peer, msg::Refuse{why});
    return;
  }
  std::visit(
      [&](const auto& m) {
        if constexpr (requires { m.request; }) {
          fail_request(peer, m.request, 2, why + ": it may not ask this");
        }
      },
      message);
}

void Coordinator::receive(Time now, Delivery delivery) {
  now_ = now;
  if (workers_.at(delivery.peer) == nullptr && !requests_.allow(now, delivery.peer)) {
    warnings_.warn(now, "more messages from one peer than --max-requests: dropped");
    return;
  }
  try {
    Message message = delivery.content.open();
    sender_ = std::move(delivery.sender);
    if (!may_say(sender_.role, message)) {
      refuse(now, delivery.peer, message);
      return;
    }
    std::visit([&](auto& m) { on(now, delivery.peer, m); }, message);
  } catch (const ProtocolError& error) {
    ++tally_.malformed;
    warnings_.warn(now, std::string("malformed message dropped: ") + error.what());
    if (error.request()) {
      fail_request(delivery.peer, *error.request(), 2, error.what());
    }
  }
}

/// Who seems silent, or late, is judged only when everything that they have sent is in.
Time Coordinator::tick(Time now, bool drained) {
  now_ = now;
  began_ = std::min(began_, now);
  if (wall_zero_ == 0) {
    wall_zero_ = options_.wall_clock() - to_seconds(now);
  }
  backroom_.run_finished();
  const bool cases_open = !desk_.idle();
  take_referee_turn(now);
  note_storage(now);
  keep_house(now);
  if (drained) {
    for (const PeerId& peer : workers_.silent(now)) {
      lose_worker(now, peer, "silent for too long", true);
    }
    expire_leases(now);
  }
  if (grant_again_at_ <= now) {
    grant_again_at_ = workers_.end_denials(now);
    grants_due_ = true;
    hold_back(now);
  }
  if (cases_open || grants_due_) {
    look_after_checks();
  }
  grant_leases(now);
  backroom_.run_finished();  // what has been prepared meanwhile
  if (!grant_leases(now)) {
    return now;
  }
  Time next = std::min(
      {workers_.size() > 0 ? now + options_.heartbeat : never, grant_again_at_, desk_.next(now)});
  for (const JobId id : at_work_) {
    const Job& job = jobs_.at(id);
    if (job.work && job.work->leases) {
      next = std::min(next, job.work->leases->next_deadline());
    }
  }
  return next;
}

std::vector<Delivery> Coordinator::take_outbox() { return std::exchange(outbox_, {}); }

void Coordinator::leave(const std::string& reason) {
  for (const auto& [peer, worker] : workers_) {
    send(peer, msg::Bye{reason});
  }
}

void Coordinator::send(const PeerId& peer, Message message) {
  outbox_.push_back({peer, Envelope(std::move(message))});
}

void Coordinator::fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                               const std::string& message) {
  send(peer, msg::Error{request, status, message});
}

/// Why a worker cannot be one of ours; empty: it can.
std::string Coordinator::refusal_of(const msg::Hello& hello) const {
  if (hello.version != protocol_version) {
    return "protocol version " + std::to_string(hello.version) + ", but this coordinator speaks " +
           std::to_string(protocol_version) + ": install the same release on both";
  }
  if (hello.trace != trace_version) {
    return "trace version " + std::to_string(hello.trace) +
           ", but this coordinator's pictures are of " + std::to_string(trace_version) +
           ": install the same release on both";
  }
  if (hello.fingerprint != options_.fingerprint) {
    return "it traces other bits than this coordinator (the built-in test picture differs): build "
           "both from the same sources, without fast-math, or test that machine's memory";
  }
  return {};
}

void Coordinator::on(Time now, const PeerId& peer, msg::Hello& m) {
  if (released_) {
    return;
  }
  std::string refusal = refusal_of(m);
  WorkerRecord* known = workers_.at(peer);
  if (refusal.empty() && known != nullptr && known->hello.instance != m.instance) {
    lose_worker(now, peer, "started again", true);
    known = nullptr;
  }
  if (refusal.empty() && known == nullptr && workers_.size() >= options_.max_workers) {
    refusal = "this coordinator has its " + std::to_string(options_.max_workers) +
              " workers: raise --max-workers";
  }
  if (!refusal.empty()) {
    warnings_.warn(now, "worker '" + m.name + "' refused: " + refusal);
    send(peer, msg::Refuse{refusal});
    return;
  }
  if (known == nullptr) {
    known = &workers_.add(now, peer, m, sender_);
    judge_losses(now, *known);
    machines_.note(known->machine, m.name);
    bar_as_due(*known);
    hold_back(now);
    grants_due_ = true;
    arrivals_.info(
        now, fmt::format("worker {} '{}' joined with {} threads", known->id, m.name, m.threads));
  }
  known->last_heard = now;
  welcome(*known);
}

/// How many times as long as those of a small farm heartbeats and silences are now.
unsigned Coordinator::pace() const {
  const Time longest = std::min(options_.lease_timeout / 3, longest_heartbeat);
  const auto most = static_cast<std::size_t>(std::max<Time::rep>(1, longest / options_.heartbeat));
  const std::size_t wanted = divide_up(workers_.size(), options_.heartbeat_workers);
  return static_cast<unsigned>(std::clamp(wanted, std::size_t{1}, most));
}

void Coordinator::welcome(WorkerRecord& worker) {
  const auto ms = [](Time t) {
    return static_cast<std::uint32_t>(std::chrono::duration_cast<milliseconds>(t).count());
  };
  worker.pace = pace();
  const Time silence = std::min(worker.pace * options_.silence, longest_silence);
  worker.silence = std::max(worker.silence, silence);
  send(worker.peer, msg::Welcome{ms(worker.pace * options_.heartbeat), ms(silence)});
}

/// The worker, of which there is word now; null once a stranger has been asked who it is: it
/// repeats what it has said once it is known.
WorkerRecord* Coordinator::heard_from(Time now, const PeerId& peer) {
  WorkerRecord* worker = workers_.at(peer);
  if (worker == nullptr) {
    if (!released_) {
      send(peer, msg::Who{});
    }
  } else {
    worker->last_heard = now;
    worker->ours = worker->ours && sender_.ours;
  }
  return worker;
}

void Coordinator::on(Time now, const PeerId& peer, msg::Heartbeat& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) {
    return;
  }
  note_progress(now, *worker, m);
  const Time deadline = worker->traced_at + options_.lease_timeout;
  for (const auto& [job_id, epoch] : m.epochs) {
    Job* job = job_of(job_id);
    const bool held = job != nullptr && job->work && job->work->leases &&
                      job->work->leases->extend(worker->id, epoch, deadline);
    if (!held) {
      send(peer, msg::Revoke{job_id, epoch});  // it works on what is no longer its own
    }
  }
  worker->tracing = m.epochs.empty() ? std::nullopt : std::optional(m.epochs.front());
  if (worker->pace == pace()) {
    send(peer, msg::Pulse{});
  } else {
    welcome(*worker);
  }
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

void Coordinator::on(Time now, const PeerId& peer, msg::Bye& m) {
  lose_worker(now, peer, m.reason, false);
}

}  // namespace parray::coordinator
