#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "proto/actor.h"
#include "proto/messages.h"
#include "worker/team.h"

namespace parray {

struct WorkerOptions {
  std::string name;      ///< for people: host name and process id, say
  std::string instance;  ///< different for every start of a worker
  std::uint32_t threads = 1;
  /// Leases in flight: one being traced, the next at hand, so that the team never waits for a
  /// message. More only helps where a lease is shorter than a message's way.
  std::uint32_t capacity = 2;
  std::string fingerprint;
};

/// A worker's side of PROTOCOL.md: says hello, keeps scenes and leases, feeds the team, repeats
/// results until they are acknowledged. Plain state, driven by one thread.
class Worker final : public Actor {
 public:
  Worker(WorkerOptions options, Team& team);

  void receive(Time now, Delivery delivery) override;
  Time tick(Time now) override;
  std::vector<Delivery> take_outbox() override;

  /// Says goodbye and drops all leases; the next outbox carries the message.
  void leave(const std::string& reason);

  /// Not empty once the coordinator has refused this worker.
  [[nodiscard]] const std::string& refused() const { return refusal_; }
  [[nodiscard]] bool connected() const { return connected_; }

 private:
  using LeaseKey = std::pair<std::uint64_t, std::uint64_t>;  // job, epoch

  struct Unacknowledged {
    Frames frames;
    Time resend_at;
  };

  void on(Time now, msg::Welcome& m);
  void on(Time now, msg::Refuse& m);
  void on(Time now, msg::Pulse& m);
  void on(Time now, msg::Who& m);
  void on(Time now, msg::Grant& m);
  void on(Time now, msg::SceneData& m);
  void on(Time now, msg::VerdictOf& m);
  void on(Time now, msg::Revoke& m);
  void on(Time now, msg::Bye& m);
  template <typename Other>
  void on(Time /*now*/, Other& /*m*/) {}  // not for workers: ignored

  void send(const Message& message);
  void disconnect(Time now);
  void collect(Time now);
  void start_next(Time now);
  void ask_for_scene(Time now);
  void beat(Time now);
  Time send_results_again(Time now);
  [[nodiscard]] bool holds(const LeaseKey& key) const;
  void forget(const LeaseKey& key);

  const WorkerOptions options_;
  Team& team_;
  bool connected_ = false;
  std::string refusal_;
  Time heartbeat_ = seconds(1);
  Time silence_ = seconds(5);
  Time last_heard_ = Time::min();
  Time next_beat_ = Time::min();
  Time next_scene_request_ = Time::min();
  std::deque<msg::Grant> waiting_;   ///< leases not started
  std::optional<LeaseKey> tracing_;  ///< the lease that the team has
  std::map<LeaseKey, Unacknowledged> results_;
  std::map<std::string, std::shared_ptr<const Scene>> scenes_;  ///< by digest; the last few
  std::deque<std::string> scene_age_;                           ///< digests, oldest use first
  std::vector<Delivery> outbox_;
};

}  // namespace parray
