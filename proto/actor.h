#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "proto/link.h"

namespace parray::proto {

/// A state machine driven by messages and time, such as the coordinator and the worker. It does no
/// I/O and never sleeps, so that a test can drive it through any history.
class Actor {
 public:
  virtual ~Actor() = default;

  /// Takes in a message.
  virtual void receive(Time now, Delivery delivery) = 0;

  /// Does the work that is due. Returns the time of the next call; `never` if the actor waits only
  /// for messages. `drained` means that the actor has received everything that had arrived. Only
  /// then does a peer without messages count as silent.
  virtual Time tick(Time now, bool drained) = 0;

  /// Returns the messages to send, in order, and empties the outbox.
  virtual std::vector<Delivery> take_outbox() = 0;
};

/// Makes one turn of an actor's loop: takes in messages, does the due work and sends the outbox.
/// Returns the actor's next deadline, or `now` if messages may still wait.
inline Time take_turn(Actor& actor, Link& link, Time now) {
  constexpr int most = 256;  // bound that keeps a flood of messages from delaying deadlines
  bool drained = false;
  const auto send = [&] {
    for (Delivery& delivery : actor.take_outbox()) {
      link.send(delivery.peer,
                std::move(delivery.content));  // the actor repeats lost messages
    }
  };
  for (int i = 0; i < most && !drained; ++i) {
    auto delivery = link.receive();
    drained = !delivery;
    if (delivery) {
      actor.receive(now, std::move(*delivery));
      send();  // a sender gets its reply before later messages are read
    }
  }
  const Time deadline = actor.tick(now, drained);
  send();
  return drained ? deadline : now;
}

/// Drives an actor until `stop` returns true. Calls `stop` after each turn. Waits at most 50 ms
/// between two turns.
inline void run_actor(Actor& actor, Link& link, const Clock& clock,
                      const std::function<bool(Time)>& stop) {
  constexpr Time nap = milliseconds(50);
  for (;;) {
    const Time deadline = take_turn(actor, link, clock.now());
    const Time now = clock.now();
    if (stop(now)) return;
    link.wait(std::clamp(deadline - now, Time(0), nap));
  }
}

}  // namespace parray::proto
