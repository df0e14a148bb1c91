#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "common/log/logger.h"
#include "coordinator/replica/replica.h"
#include "proto/clock.h"
#include "proto/zmq_link.h"

namespace parray::replica {

/// Answers the primary. Returns when the primary has been silent for `patience` while the store was
/// in step with it: the caller may then take over. While the store is not in step, logs the
/// remedies after a silence of `patience`, then every hour. Time in which this process did not run
/// does not count. Calls `stop` at least every 50 ms; an exception of `stop` ends the wait. Throws
/// what Replica::answer() throws.
void standby_loop(Replica& replica, Link& link, Time patience, spdlog::logger& log,
                  const std::function<void()>& stop);

/// Answers every request of an old primary with `fenced`, in a thread of its own.
class Fence {
 public:
  /// `generation`: that of the coordinator that has taken over. The answers contain it.
  Fence(std::unique_ptr<ZmqServer> server, std::uint64_t generation);
  ~Fence();
  Fence& operator=(Fence&&) = delete;

 private:
  void run();

  const std::unique_ptr<ZmqServer> server_;
  const std::uint64_t generation_;
  std::atomic<bool> quit_ = false;
  std::thread thread_;
};

}  // namespace parray::replica
