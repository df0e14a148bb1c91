#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/log/logger.h"
#include "coordinator/replica/replica_thread.h"
#include "coordinator/replica/replicated_store.h"
#include "proto/clock.h"
#include "proto/zmq_link.h"

namespace parray::replica {

/// The options of a coordinator's command line about its state.
struct StateOptions {
  std::string state;          ///< directory; empty: state in memory only, other members are ignored
  bool wait = false;          ///< waits for the end of another coordinator that uses the directory
  std::string standby;        ///< address at which this standby listens; empty: not a standby
  Time takeover_after{};      ///< silence of the primary before a standby takes over
  std::string replicate_to;   ///< address of the standby of this primary; empty: none
  bool overwrite = false;     ///< the standby accepts a primary with an older state than its own
  bool serve_fenced = false;  ///< the primary serves although a standby has taken over
  std::string keys;           ///< directory of the keys, see ZmqServer
};

/// Opens the state of a coordinator and owns it while the coordinator serves.
class StateOwner {
 public:
  /// Opens the state and returns when this process may serve: a standby waits for its takeover.
  /// Calls `stop` at least every 100 ms meanwhile; an exception of `stop` ends the wait. Throws
  /// InputError if a standby has taken over from this state, unless this process is to be a standby
  /// or `serve_fenced` is set. Throws what DiskStore, Replica, ReplicatedStore and the link throw.
  StateOwner(const StateOptions& options, spdlog::logger& log, const std::function<void()>& stop);

  Store* store();  ///< owned by this object; null: state in memory only
  [[nodiscard]] bool replicates() const { return replicated_ != nullptr; }  ///< has a standby
  /// Whether the standby has taken over. The state then accepts no commit any more.
  [[nodiscard]] bool fenced() const { return connection_ != nullptr && connection_->fenced(); }
  /// Records in the state that the standby has taken over, and closes the state: the result of
  /// store() is no longer valid.
  void remember_fence();

 private:
  void take_over(const StateOptions& options, spdlog::logger& log,
                 const std::function<void()>& stop);
  void replicate(const StateOptions& options);

  std::string directory_;  ///< of the state
  std::unique_ptr<Store> disk_;
  std::unique_ptr<ReplicaThread> connection_;
  std::unique_ptr<ReplicatedStore> replicated_;
  std::optional<ZmqServer> standby_;  ///< where a primary calls this standby
  std::jthread fence_;  ///< after a takeover, answers each request of the old primary with `fenced`
};

}  // namespace parray::replica
