#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "coordinator/loop/farm.h"

namespace parray::coordinator {

/// Passes a client's request for the log of a worker on to the worker, and its answer back. A
/// worker that does not answer delays nothing: the client gets an error.
class WorkerLogs {
 public:
  /// Requests that may wait for workers at a time. One that came by HTTP occupies a thread there.
  static constexpr std::size_t most_waiting = 16;
  /// Time in which a worker must answer.
  static constexpr Time patience = seconds(3);

  explicit WorkerLogs(Farm& farm) : farm_(farm) {}

  /// Handles a client's request. Ignores a repeated one that still waits.
  void on(Time now, const PeerId& peer, msg::ShowLog& m);
  /// Handles a worker's answer. Ignores it if no client waits for it.
  void on(Time now, const PeerId& peer, msg::Log& m);
  /// Answers the requests whose worker has not answered in time. Returns when it is due again.
  Time expire(Time now);

 private:
  struct Waiting {
    PeerId client;
    std::uint64_t request = 0;  ///< the client's number
    PeerId worker;
    std::string name;  ///< of the worker
    Time until{};
  };

  Farm& farm_;
  std::map<std::uint64_t, Waiting> waiting_;  ///< by the number that the worker repeats
  std::uint64_t next_ = 1;
};

}  // namespace parray::coordinator
