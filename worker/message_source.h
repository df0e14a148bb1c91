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

struct WorkerOptions {
  std::string name;      ///< for people: host name and process id, say
  std::string instance;  ///< different for every start of a worker
  std::uint32_t threads = 1;
  /// Leases in flight: one being traced, the next at hand, so that the team never waits for a
  /// message. More only helps where a lease is shorter than a message's way.
  std::uint32_t capacity = 2;
  std::string fingerprint;
  /// The coordinator is in this process: messages travel as they are, and scenes are believed.
  bool in_process = false;
  /// Of the machine: workers of one let a scene come to it once.
  std::string host{};
  /// Where the link takes the requests of other workers, and the public key there; 0: nowhere.
  std::uint32_t share_port = 0;
  std::string share_key{};
  /// Ends the link's wait from another thread; without it large scenes are opened in this one.
  std::function<void()> wake{};
};

/// Leases by messages, a worker's side of PROTOCOL.md: says hello, keeps scenes and granted leases,
/// repeats results and failures until the coordinator has heard of them. Other workers are listened
/// to where scenes are concerned, and nowhere else.
///
/// After a silence it says hello again but keeps what it holds: the coordinator revokes what is no
/// longer this worker's. Only `who` and `bye` mean that it has forgotten: then leases that wait are
/// dropped, because it will grant their cells again; results are kept all the same.
class MessageSource final : public LeaseSource {
 public:
  explicit MessageSource(WorkerOptions options)
      : options_(std::move(options)), exchange_(options_.wake) {}

  /// `from`: empty for the coordinator.
  void receive(Time now, const PeerId& from, const Envelope& content);

  Taken take(Time now, double samples_per_second, bool idle) override;
  void complete(Time now, Finished finished) override;
  [[nodiscard]] bool wants(const LeaseKey& lease) const override { return tracing_ == lease; }
  Time tick(Time now, const TeamState& team) override;

  /// Messages to send, in order; empties the outbox.
  std::vector<Delivery> take_outbox();
  /// Says goodbye and drops everything.
  void leave(const std::string& reason);

  /// Not empty once the coordinator has refused this worker.
  [[nodiscard]] const std::string& refused() const { return refusal_; }
  /// Leases that wait, or whose results nobody has acknowledged.
  [[nodiscard]] bool holds_any() const { return !waiting_.empty() || !unacknowledged_.empty(); }
  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] const SceneExchange::Tally& scene_bytes() const { return exchange_.tally(); }

 private:
  /// A result, or that there is none.
  struct Unacknowledged {
    Envelope message;
    Time resend_at;
  };

  void on(Time now, msg::Welcome& m);
  void on(Time now, msg::Refuse& m);
  void on(Time now, msg::Pulse& m);
  void on(Time now, msg::Who& m);
  void on(Time now, msg::Grant& m);
  void on(Time now, msg::ResultVerdict& m);
  void on(Time now, msg::Revoke& m);
  void on(Time now, msg::Bye& m);
  template <typename Other>
  void on(Time /*now*/, Other& /*m*/) {}  // not for workers: ignored

  void send(Message message) { outbox_.push_back({{}, std::move(message)}); }
  void reconnect(Time now);
  void forgotten(Time now);
  [[nodiscard]] bool knows(const std::string& scene) const;
  Time fetch_scenes(Time now);
  void fail_waiting(Time now, const std::string& scene, const std::string& reason);
  void keep_until_heard(Time now, const LeaseKey& lease, Message message);
  void beat(Time now, const TeamState& team);
  Time repeat_unacknowledged(Time now);
  [[nodiscard]] bool holds(const LeaseKey& lease) const;

  const WorkerOptions options_;
  bool connected_ = false;
  std::string refusal_;
  Time heartbeat_ = seconds(1);
  Time silence_ = seconds(5);
  Time last_heard_ = Time::min();
  Time next_beat_ = Time::min();
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
