#include "coordinator/loop/coordinator.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace parray::coordinator {

Coordinator::Coordinator(CoordinatorOptions options, Store* store,
                         std::shared_ptr<spdlog::logger> log)
    : farm_(std::move(options), store, std::move(log), job_thread_),
      worker_desk_(farm_, job_book_, leases_, disputes_),
      job_book_(farm_, disputes_, worker_desk_),
      leases_(farm_, job_book_, disputes_, worker_desk_),
      disputes_(farm_, job_book_),
      clients_(farm_, job_book_, leases_, disputes_, worker_desk_),
      worker_logs_(farm_),
      requests_(farm_.options.limits.requests),
      job_thread_(store, farm_.options.job_thread) {
  disputes_.restore_worker_notes();
  job_book_.restore_jobs();
}

/// Passes a message to the part that handles it.
void Coordinator::dispatch(Time now, const PeerId& peer, auto& m) {
  if constexpr (requires { worker_desk_.on(now, peer, m); }) {
    worker_desk_.on(now, peer, m);
  } else if constexpr (requires { leases_.on(now, peer, m); }) {
    leases_.on(now, peer, m);
  } else if constexpr (requires { job_book_.on(now, peer, m); }) {
    job_book_.on(now, peer, m);
  } else if constexpr (requires { clients_.on(now, peer, m); }) {
    clients_.on(now, peer, m);
  } else if constexpr (requires { worker_logs_.on(now, peer, m); }) {
    worker_logs_.on(now, peer, m);
  } else {
    ++farm_.tally.malformed;
    farm_.warnings.warn(now, "dropped a message that is not meant for coordinators");
  }
}

/// Returns whether only workers send such messages. Clients send all others.
static bool is_worker_message(const Message& message) {
  return std::holds_alternative<msg::Hello>(message) ||
         std::holds_alternative<msg::Heartbeat>(message) ||
         std::holds_alternative<msg::NeedScene>(message) ||
         std::holds_alternative<msg::NeedChunk>(message) ||
         std::holds_alternative<msg::Result>(message) ||
         std::holds_alternative<msg::Failed>(message) ||
         std::holds_alternative<msg::Log>(message) || std::holds_alternative<msg::Bye>(message);
}

static bool may_send(Role role, const Message& message) {
  switch (role) {
    case Role::any: return true;
    case Role::worker: return is_worker_message(message);
    case Role::client:
    case Role::admin: return !is_worker_message(message);
    case Role::none: break;
  }
  return false;
}

/// Answers a message that the sender's key does not permit.
void Coordinator::refuse(Time now, const PeerId& peer, const Message& message) {
  ++farm_.tally.malformed;
  const std::string why = farm_.sender.role == Role::none
                              ? "the worker's or client's key is no longer allowed"
                              : fmt::format("the key '{}' has the role {}", farm_.sender.name,
                                            name_of(farm_.sender.role));
  farm_.warnings.warn(now, "refused a message: " + why);
  if (is_worker_message(message)) {
    if (farm_.workers.at(peer) != nullptr) worker_desk_.lose_worker(now, peer, why, false);
    farm_.send(peer, msg::Bye{why});  // the worker may have joined before
    farm_.send(peer, msg::Refuse{why});
    return;
  }
  std::visit(
      [&](const auto& m) {
        if constexpr (requires { m.request; }) {
          farm_.fail_request(peer, m.request, 2,
                             farm_.sender.role == Role::none
                                 ? "this key is no longer allowed: ask an administrator for another"
                                 : why + ": only clients and administrators may ask this");
        }
      },
      message);
}

void Coordinator::receive(Time now, Delivery delivery) {
  farm_.now = now;
  if (farm_.workers.at(delivery.peer) == nullptr && !requests_.allow(now, delivery.peer)) {
    farm_.warnings.warn(now, "dropped messages: a peer sent more than --max-requests per second");
    return;
  }
  try {
    Message message = delivery.content.open();
    farm_.sender = std::move(delivery.sender);
    if (!may_send(farm_.sender.role, message)) {
      refuse(now, delivery.peer, message);
      return;
    }
    std::visit([&](auto& m) { dispatch(now, delivery.peer, m); }, message);
  } catch (const ProtocolError& error) {
    ++farm_.tally.malformed;
    farm_.warnings.warn(now, std::string("dropped a malformed message: ") + error.what());
    if (error.request()) farm_.fail_request(delivery.peer, *error.request(), 2, error.what());
  }
}

/// Looks for silent workers and expired leases only when all received messages are handled.
Time Coordinator::tick(Time now, bool drained) {
  farm_.now = now;
  if (farm_.began == never) {
    farm_.began = now;
    farm_.wall_zero = farm_.options.wall_clock() - to_seconds(now);
    farm_.announce(FarmEventKind::started, "", "the coordinator was started");
  }
  farm_.note_history();
  farm_.job_thread.run_finished();
  const bool cases_open = !disputes_.referee().idle();
  disputes_.take_referee_turn(now);
  worker_desk_.note_storage(now);
  job_book_.keep_house(now);
  if (drained) {
    for (const PeerId& peer : farm_.workers.silent(now)) {
      worker_desk_.lose_worker(now, peer, "silent for too long", true);
    }
    leases_.expire_leases(now);
  }
  if (farm_.grant_again_at <= now) {
    farm_.grant_again_at = farm_.workers.end_denials(now);
    farm_.grants_due = true;
    leases_.hold_back(now);
  }
  if (cases_open || farm_.grants_due) disputes_.look_after_checks();
  const Time log_due = worker_logs_.expire(now);
  leases_.grant_leases(now);
  farm_.job_thread.run_finished();  // for passes that the job thread has just prepared
  if (!leases_.grant_leases(now)) return now;
  return std::min({farm_.workers.size() > 0 ? now + farm_.options.heartbeat : never,
                   farm_.grant_again_at, log_due, disputes_.referee().next(now),
                   leases_.next_deadline()});
}

void Coordinator::leave(const std::string& reason) {
  for (const auto& [peer, worker] : farm_.workers) farm_.send(peer, msg::Bye{reason});
}

void Coordinator::keep_progress() {
  if (farm_.store == nullptr) return;
  job_book_.keep_farm_notes();
  job_thread_.settle(seconds(2));
}

std::future<void> Coordinator::keep_note(const std::string& name, std::string text) {
  const auto kept = std::make_shared<std::promise<void>>();
  std::future<void> result = kept->get_future();
  auto task = [store = farm_.store, name, text = std::move(text), kept]() -> JobThread::Completion {
    if (store != nullptr) store->put_note(name, text);
    return {{}, [kept] { kept->set_value(); }};
  };
  farm_.for_log("storing the note " + name, std::move(task));
  return result;
}

}  // namespace parray::coordinator
