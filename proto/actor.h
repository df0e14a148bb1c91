#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "proto/link.h"

namespace parray::proto {

/// A state machine that lives on messages and time: the coordinator and the worker are two. It does
/// no I/O and never sleeps, so that a test can drive it through any history.
class Actor {
 public:
  virtual ~Actor() = default;

  /// Takes a message in.
  virtual void receive(Time now, Delivery delivery) = 0;

  /// Does what is due. Returns when it wants to be called again; `never` if only for messages.
  /// `drained`: everything that had arrived has been taken in, so that who seems silent is.
  virtual Time tick(Time now, bool drained) = 0;

  /// Messages to send, in order; empties the outbox.
  virtual std::vector<Delivery> take_outbox() = 0;
};

/// One turn of an actor's loop: what has arrived, everything due, everything to send. Returns the
/// actor's next deadline.
inline Time take_turn(Actor& actor, Link& link, Time now) {
  constexpr int most = 256;  // so that a flood of messages cannot keep deadlines waiting
  bool drained = false;
  const auto send = [&] {
    for (Delivery& delivery : actor.take_outbox()) {
      link.send(delivery.peer,
                std::move(delivery.content));  // a lost message is the actor's to repeat
    }
  };
  for (int i = 0; i < most && !drained; ++i) {
    auto delivery = link.receive();
    drained = !delivery;
    if (delivery) {
      actor.receive(now, std::move(*delivery));
      send();  // who asks is not to wait for all behind him
    }
  }
  const Time deadline = actor.tick(now, drained);
  send();
  return drained ? deadline : now;
}

/// Drives an actor until `stop` says so; `stop` is asked at least every 50 ms.
inline void run_actor(Actor& actor, Link& link, const Clock& clock,
                      const std::function<bool(Time)>& stop) {
  constexpr Time nap = milliseconds(50);
  for (;;) {
    const Time deadline = take_turn(actor, link, clock.now());
    const Time now = clock.now();
    if (stop(now)) {
      return;
    }
    link.wait(std::clamp(deadline - now, Time(0), nap));
  }
}

}  // namespace parray::proto
