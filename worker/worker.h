#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/actor.h"
#include "worker/lease_runner.h"
#include "worker/message_source.h"

namespace parray::worker {

/// A worker that reaches its coordinator by messages and keeps its team at work. Not thread-safe.
class Worker final : public Actor {
 public:
  /// `team` must outlive the worker.
  Worker(WorkerOptions options, Team& team)
      : source_(std::move(options)), runner_(source_, team, clock_) {}

  void receive(Time now, Delivery delivery) override {
    source_.receive(now, delivery.peer, delivery.content);
  }
  Time tick(Time now, bool /*drained*/) override {
    clock_.time = now;
    return runner_.tick(now);
  }
  std::vector<Delivery> take_outbox() override { return source_.take_outbox(); }

  /// Drops all leases and sends `bye`: the next take_outbox() returns the message.
  void leave(const std::string& reason) {
    runner_.stop();
    source_.leave(reason);
  }

  /// Returns the reason of the coordinator's refusal; empty if it has not refused this worker.
  [[nodiscard]] const std::string& refused() const { return source_.refused(); }
  [[nodiscard]] bool connected() const { return source_.connected(); }
  /// Returns whether the worker has nothing to trace and no unacknowledged result.
  [[nodiscard]] bool idle() const { return runner_.idle() && !source_.holds_any(); }
  [[nodiscard]] const SceneExchange::Tally& scene_bytes() const { return source_.scene_bytes(); }

 private:
  /// A clock that stands still within a turn.
  struct TurnClock final : Clock {
    [[nodiscard]] Time now() const override { return time; }
    Time time{};
  };

  TurnClock clock_;
  MessageSource source_;
  LeaseRunner runner_;
};

}  // namespace parray::worker
