#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/link.h"
#include "worker/lease_source.h"
#include "worker/scene_exchange.h"

namespace parray::worker {

/// The options of a worker that reaches its coordinator by messages, and what it says of itself.
struct WorkerOptions : msg::Hello {
  /// The coordinator runs in this process: messages travel without encoding, and scenes are not
  /// checked.
  bool in_process = false;
  /// Returns the load average of the last minute; negative: not known. May be empty.
  std::function<double()> load{};
  /// Returns the last lines of this worker's log, oldest first. May be empty.
  std::function<std::vector<std::string>()> recent_log{};
  /// Ends the link's wait from another thread. Without it, this thread opens the scenes.
  std::function<void()> wake{};
};

/// Receives leases by messages: the worker's side of PROTOCOL.md. Says hello, keeps scenes and
/// granted leases, and repeats results and failures until the coordinator acknowledges them. It
/// accepts messages about scenes from other workers, and all other messages only from the
/// coordinator.
///
/// After a silence it says hello again but keeps its leases and results. The coordinator revokes
/// the leases that no longer belong to this worker. Only `who` and `bye` mean that the coordinator
/// has forgotten the worker. Then the source drops waiting leases, because the coordinator will
/// grant their cells again. It keeps results even then.
class MessageSource final : public LeaseSource {
 public:
  explicit MessageSource(WorkerOptions options)
      : options_(std::move(options)), exchange_(options_.wake) {}

  /// Takes in a message. `from` is empty for the coordinator.
  void receive(Time now, const PeerId& from, const Envelope& content);

  Taken take(Time now, double samples_per_second, bool idle) override;
  void complete(Time now, LeaseResult finished) override;
  [[nodiscard]] bool wants(const LeaseKey& lease) const override { return tracing_ == lease; }
  Time tick(Time now, const TeamState& team) override;

  /// Returns the messages to send, in order, and empties the outbox.
  std::vector<Delivery> take_outbox();
  /// Sends `bye` to the coordinator and drops all leases and results.
  void leave(const std::string& reason);

  /// Returns the reason of the coordinator's refusal; empty if it has not refused this worker.
  [[nodiscard]] const std::string& refused() const { return refusal_; }
  /// Returns whether there are waiting leases or unacknowledged results.
  [[nodiscard]] bool holds_any() const { return !waiting_.empty() || !unacknowledged_.empty(); }
  /// Returns whether the coordinator has sent `welcome` and not been silent or forgotten this
  /// worker since.
  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] const SceneExchange::Tally& scene_bytes() const { return exchange_.tally(); }

 private:
  /// A result or the report of a failure.
  struct Unacknowledged {
    Envelope message;
    Time resend_at;
  };

  void on(Time now, msg::Welcome& m);
  void on(Time now, msg::Refuse& m);
  void on(Time now, msg::Identify& /*m*/) { on_forgotten(now); }
  void on(Time now, msg::Grant& m);
  void on(Time now, msg::ResultVerdict& m);
  void on(Time now, msg::Revoke& m);
  void on(Time now, msg::Bye& /*m*/) { on_forgotten(now); }
  void on(Time now, msg::ShowLog& m);
  template <typename Other>
  void on(Time /*now*/, Other& /*m*/) {}  // ignores messages that are not for workers

  void send(Message message) { outbox_.push_back({{}, std::move(message)}); }
  void reconnect(Time now);
  void on_forgotten(Time now);
  [[nodiscard]] bool knows(const std::string& scene) const;
  Time fetch_scenes(Time now);
  void fail_waiting(Time now, const std::string& scene, const std::string& reason);
  void keep_until_acknowledged(Time now, const LeaseKey& lease, Message message);
  void send_heartbeat(Time now, const TeamState& team);
  Time repeat_unacknowledged(Time now);
  [[nodiscard]] bool holds(const LeaseKey& lease) const;

  const WorkerOptions options_;
  bool connected_ = false;
  std::string refusal_;
  Time heartbeat_ = seconds(1);
  Time silence_ = seconds(5);
  Time last_heard_ = Time::min();
  Time next_heartbeat_ = Time::min();
  std::deque<msg::Grant> waiting_;   ///< leases not taken
  std::optional<LeaseKey> tracing_;  ///< the lease that was taken
  std::map<LeaseKey, Unacknowledged> unacknowledged_;
  struct KnownScene {
    std::string id;
    std::shared_ptr<const Scene> scene;
  };
  std::deque<KnownScene> scenes_;  ///< the last few, oldest use first
  SceneExchange exchange_;
  std::vector<Delivery> outbox_;
};

}  // namespace parray::worker
