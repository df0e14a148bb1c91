#include "coordinator/replica/state_owner.h"

#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "coordinator/store/disk_store.h"
#include "proto/keys.h"
#include "proto/zmq_link.h"

namespace parray::replica {
namespace {

constexpr std::size_t most_message_bytes = std::size_t{64} << 20;  // pieces are far smaller

std::unique_ptr<Store> open_store(const std::string& directory, spdlog::logger& log) {
  auto store = std::make_unique<DiskStore>(directory);
  for (const std::string& line : store->reports()) log.warn("--state {}: {}", directory, line);
  return store;
}

std::unique_ptr<Store> wait_for_store(const std::string& directory, spdlog::logger& log,
                                      const std::function<void()>& stop) {
  constexpr Time nap = milliseconds(100);
  for (bool told = false;;) {
    try {
      return open_store(directory, log);
    } catch (const StateInUse&) {
      if (!std::exchange(told, true)) {
        log.info("another coordinator uses --state {}: waiting for its end", directory);
      }
    }
    std::this_thread::sleep_for(nap);
    stop();
  }
}

std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) + device();
}

}  // namespace

StateOwner::StateOwner(const StateOptions& options, spdlog::logger& log,
                       const std::function<void()>& stop)
    : directory_(options.state) {
  if (options.state.empty()) return;
  disk_ = options.wait ? wait_for_store(options.state, log, stop) : open_store(options.state, log);
  if (options.standby.empty()) check_fence(*disk_, options.serve_fenced, random_number() | 1);
  if (!options.standby.empty()) {
    take_over(options, log, stop);
  } else if (!options.replicate_to.empty()) {
    replicate(options);
  } else {
    serve_alone(*disk_);
  }
}

void StateOwner::remember_fence() {
  replicated_.reset();
  connection_.reset();
  disk_.reset();
  DiskStore store(directory_);  // without uncommitted changes
  note_fence(store);
}

Store* StateOwner::store() { return replicated_ ? replicated_.get() : disk_.get(); }

void StateOwner::take_over(const StateOptions& options, spdlog::logger& log,
                           const std::function<void()>& stop) {
  auto server = std::make_unique<ZmqServer>(options.standby, most_message_bytes, options.keys,
                                            Admits::itself);
  Replica replica(*disk_, options.overwrite);
  if (!replica.has_taken_over()) {
    log.info("standing by for a primary at {}", server->endpoint());
    standby_loop(replica, server->link(), options.takeover_after, log, stop);
  }
  const bool earlier = replica.has_taken_over();
  const std::uint64_t generation = serve_alone(*disk_);
  log.warn(
      "{}: it serves now, as generation {} of the farm's state. To have a standby again, start {} "
      "with --standby, and this coordinator with --replicate-to",
      earlier ? "this coordinator is no standby, because its state has served without one"
              : "the primary is silent, and this standby has taken over",
      generation,
      earlier ? "another coordinator with an empty directory and" : "the former primary");
  fence_ = std::make_unique<Fence>(std::move(server), generation);
}

void StateOwner::replicate(const StateOptions& options) {
  std::optional<MemberKey> key;
  if (!options.keys.empty()) {
    const KeyPair own = read_coordinator_key(options.keys);
    key = MemberKey{own.open, own};
  }
  connection_ = std::make_unique<ReplicaThread>(
      zmq_connect(options.replicate_to, most_message_bytes, Time(0), key), options.replicate_to);
  replicated_ = std::make_unique<ReplicatedStore>(*disk_, *connection_, random_number);
}

}  // namespace parray::replica
