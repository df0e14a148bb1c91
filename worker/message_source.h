#pragma once

#include <cstdint>
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

/// The options of a worker that reaches its coordinator by messages.
struct WorkerOptions {
  std::string name;      ///< name for people, for example host name and process id
  std::string instance;  ///< different for every start of a worker
  std::uint32_t threads = 1;
  /// Number of leases to hold at a time. By default one is traced while another waits, so that the
  /// team never waits for a message. More leases help only if a lease is shorter than a message's
  /// travel time.
  std::uint32_t capacity = 2;
  std::string fingerprint;  ///< trace_fingerprint() of this build
  /// The coordinator runs in this process: messages travel without encoding, and scenes are not
  /// checked.
  bool in_process = false;
  /// Host name. The coordinator prefers a worker of the same host as the source of a scene.
  std::string host{};
  /// Port for the requests of other workers, and the public key of that port. 0: no port.
  std::uint32_t share_port = 0;
  std::string share_key{};
  /// Facts about this program and its machine, for people: see msg::Hello.
  std::string release{};
  std::uint32_t processors = 0;
  std::uint64_t memory_bytes = 0;
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
  void on(Time now, msg::HeartbeatAck& m);
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
