#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/scene/scene_bytes.h"
#include "coordinator/loop/scene_service.h"
#include "proto/actor.h"
#include "tests/support/rooms.h"
#include "tests/support/sim_network.h"
#include "worker/scene_exchange.h"

namespace parray::test {

/// How a worker passes on chunks: unchanged, changed, or with a wrong checksum.
enum class Honesty { honest, lying, corrupting };

/// A worker that only gets and passes on one scene.
class SpreadWorker final : public Actor {
 public:
  SpreadWorker(std::string scene, Honesty honesty) : scene_(std::move(scene)), honesty_(honesty) {}

  void receive(Time now, Delivery delivery) override {
    try {
      Message message = delivery.content.open();
      exchange.receive(now, delivery.peer, message);
    } catch (const ProtocolError&) {
      // cut short on its way
    }
  }
  Time tick(Time now, bool /*drained*/) override {
    exchange.want(opened ? "" : scene_);
    const Time due = exchange.tick(now);
    if (auto come = exchange.take_opened()) {
      opened = std::move(come);
      opened_at = now;
    }
    return due;
  }
  std::vector<Delivery> take_outbox() override {
    std::vector<Delivery> outbox = exchange.take_outbox();
    if (honesty_ != Honesty::honest) {
      for (Delivery& delivery : outbox) delivery.content = changed(delivery.content.open());
    }
    return outbox;
  }

  SceneExchange exchange{{}};
  std::optional<OpenedScene> opened;
  Time opened_at = never;

 private:
  [[nodiscard]] Message changed(Message message) const {
    if (auto* chunk = std::get_if<msg::Chunk>(&message)) {
      std::string bytes(chunk->content.data.view());
      bytes[bytes.size() / 2] ^= 1;
      const std::uint64_t checksum = chunk->content.checksum;
      chunk->content = Bulk::of(std::move(bytes));
      if (honesty_ == Honesty::corrupting) chunk->content.checksum = checksum;
    }
    return message;
  }

  const std::string scene_;
  const Honesty honesty_;
};

/// A coordinator that only serves scenes.
class SpreadCoordinator final : public Actor {
 public:
  explicit SpreadCoordinator(const Scene& scene, std::uint32_t chunk_bytes = 1024)
      : bytes_(scene_to_bytes(scene)), id(scene_identity(bytes_.view())), service(chunk_bytes) {}

  void receive(Time /*now*/, Delivery delivery) override {
    try {
      Message message = delivery.content.open();
      if (const auto* need = std::get_if<msg::NeedScene>(&message)) {
        const WorkerRecord& worker = workers_.at(delivery.peer);
        outbox_.push_back({delivery.peer, Message(service.source_for(
                                              worker, need->scene, bytes_.size(), need->failed))});
        asked.insert(delivery.peer);
      } else if (const auto* chunk = std::get_if<msg::NeedChunk>(&message)) {
        if (auto found = service.chunk(chunk->scene, bytes_, chunk->chunk)) {
          sent[delivery.peer] += found->content.data.size();
          outbox_.push_back({delivery.peer, Message(std::move(*found))});
        }
      }
    } catch (const ProtocolError&) {
      // cut short on its way
    }
  }
  Time tick(Time /*now*/, bool /*drained*/) override { return never; }
  std::vector<Delivery> take_outbox() override { return std::exchange(outbox_, {}); }

  void add_worker(const PeerId& peer, WorkerId number, bool sharing = true) {
    WorkerRecord& worker = workers_[peer];
    worker.id = number;
    worker.address = machine_of(peer);
    worker.hello.host = "host";
    worker.hello.share_port = sharing ? static_cast<std::uint32_t>(number) : 0;
    worker.hello.share_key = SimNetwork::share_key;
  }
  [[nodiscard]] std::uint64_t sent_bytes() const {
    std::uint64_t sum = 0;
    for (const auto& [peer, bytes] : sent) sum += bytes;
    return sum;
  }

 private:
  Frame bytes_;
  std::map<PeerId, WorkerRecord> workers_;
  std::vector<Delivery> outbox_;

 public:
  const std::string id;
  SceneService service;
  std::map<PeerId, std::uint64_t> sent;  ///< bytes of chunks sent to each worker
  std::set<PeerId> asked;                ///< workers that have asked for a source
};

/// Spreads a scene to workers over a simulated network, in virtual time. Each machine has two
/// workers.
class SimSpread {
 public:
  SimSpread(const Scene& scene, std::size_t workers, Faults faults, std::uint64_t seed,
            const std::map<std::size_t, Honesty>& honesties = {})
      : network(faults, seed), coordinator(scene), coordinator_link_(network.coordinator_end()) {
    for (std::size_t i = 0; i < workers; ++i) {
      const std::size_t number = i + 2;  // workers 2 and 3 share a machine
      const PeerId peer = 'w' + std::to_string(number);
      coordinator.add_worker(peer, number);
      const auto honesty = honesties.find(i);
      workers_.push_back(std::make_unique<End>(
          End{SpreadWorker(coordinator.id,
                           honesty == honesties.end() ? Honesty::honest : honesty->second),
              network.peer_end(peer), peer}));
    }
  }

  /// Ends a worker as kill -9 does, and tells the coordinator that it is lost.
  void kill(std::size_t place) {
    coordinator.service.forget_worker(place + 2);
    workers_[place].reset();
  }
  /// Ends a worker without telling the coordinator.
  void stop(std::size_t place) { workers_[place].reset(); }
  [[nodiscard]] const SpreadWorker* worker(std::size_t place) const {
    return workers_[place] ? &workers_[place]->worker : nullptr;
  }
  [[nodiscard]] bool all_opened() const {
    for (const auto& end : workers_) {
      if (end && !(end->worker.opened && end->worker.opened->scene)) return false;
    }
    return true;
  }

  /// Runs until every remaining worker has the scene. Calls `event` before every turn. Returns
  /// false if this takes longer than until `until`.
  template <typename Event>
  bool run(Time until, Event event) {
    while (!all_opened() && network.now() < until) {
      event(*this);
      Time next = take_turn(coordinator, *coordinator_link_, network.now());
      for (const auto& end : workers_) {
        if (end) next = std::min(next, take_turn(end->worker, *end->link, network.now()));
      }
      next = std::min(next, network.next_arrival());
      network.advance_to(std::max(next, network.now() + std::chrono::microseconds(100)));
    }
    return all_opened();
  }
  bool run(Time until) {
    return run(until, [](SimSpread&) {});
  }

  SimNetwork network;
  SpreadCoordinator coordinator;

 private:
  struct End {
    SpreadWorker worker;
    std::unique_ptr<Link> link;
    PeerId peer;
  };
  std::unique_ptr<Link> coordinator_link_;
  std::vector<std::unique_ptr<End>> workers_;
};

}  // namespace parray::test
