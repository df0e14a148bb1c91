#pragma once

#include <spdlog/logger.h>

#include <functional>
#include <memory>
#include <string>

#include "coordinator/replica/replica_thread.h"
#include "coordinator/replica/replicated_store.h"
#include "coordinator/replica/standby_loop.h"
#include "proto/clock.h"

namespace parray::replica {

/// How a coordinator keeps its state, as its command line says.
struct StateOptions {
  std::string state;          ///< directory; empty: nothing is kept, and the rest is empty, too
  bool wait = false;          ///< for another coordinator that uses it
  std::string standby;        ///< address to listen at for a primary; empty: none is waited for
  Time takeover_after{};      ///< of silence
  std::string replicate_to;   ///< address of a standby; empty: there is none
  bool overwrite = false;     ///< as a standby: a primary that was set back may replace batches
  bool serve_fenced = false;  ///< as a primary: although a standby has taken over
  std::string keys;           ///< see ZmqServer
};

/// The state of a coordinator that is to serve now: its own, or one that it has taken over.
class StateOwner {
 public:
  /// Returns when it is this process's turn to serve. `stop` is asked at least every 100 ms while
  /// it waits; what it throws ends the wait. Throws what DiskStore, Replica, ReplicatedStore and
  /// the link throw.
  StateOwner(const StateOptions& options, spdlog::logger& log, const std::function<void()>& stop);

  Store* store();  ///< null: nothing is kept
  [[nodiscard]] bool replicates() const { return replicated_ != nullptr; }
  /// Another one serves: nothing can be kept here any more.
  [[nodiscard]] bool fenced() const { return line_ != nullptr && line_->fenced(); }
  /// Writes that down in the state, which nothing else uses any more, and closes the state.
  void remember_fence();

 private:
  void take_over(const StateOptions& options, spdlog::logger& log,
                 const std::function<void()>& stop);
  void replicate(const StateOptions& options);

  std::string directory_;  ///< of the state
  std::unique_ptr<Store> disk_;
  std::unique_ptr<ReplicaThread> line_;
  std::unique_ptr<ReplicatedStore> replicated_;
  std::unique_ptr<Fence> fence_;
};

}  // namespace parray::replica
