#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "coordinator/loop/machine_id.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Decides how long a worker gets no leases after it failed where another worker succeeded: 1
/// minute, then 2, 4 ... up to 64. After a success the next delay is 1 minute again.
///
/// Machine and name identify a worker. If no worker of a machine succeeds, the delay applies to the
/// whole machine. Then a worker cannot avoid it by a new name. Not thread-safe. Reads no clock.
class Backoff {
 public:
  /// Records that the worker failed at a job that other workers traced a part of. `whole`: the
  /// delay applies to the whole machine, because no worker of it has traced any part of the job.
  /// Does nothing while a delay is running.
  void note_failure(Time now, const MachineId& machine, const std::string& name, bool whole) {
    if (until(machine, name) > now) return;
    constexpr std::size_t most = 10000;  // a worker can invent names: old entries are removed
    if (entries_.size() >= most) {
      std::erase_if(entries_, [&](const auto& e) { return e.second.until + longest < now; });
    }
    Entry& entry = entries_[{machine, whole ? "" : name}];
    entry.length = entry.length == Time(0) ? first : std::min(2 * entry.length, longest);
    entry.until = now + entry.length;
  }
  /// Records that the worker traced a lease. Returns whether this ended or reset a delay.
  bool note_success(const MachineId& machine, const std::string& name) {
    return !entries_.empty() && forgive(machine, name);
  }
  /// Ends the delays of the worker and of its machine. Their next delays are 1 minute again.
  /// Returns whether there was any delay, running or past, since the last success.
  bool forgive(const MachineId& machine, const std::string& name) {
    return entries_.erase({machine, ""}) + entries_.erase({machine, name}) > 0;
  }

  /// Returns when the worker may get leases again. A time that is not after `now`: it may now.
  [[nodiscard]] Time until(const MachineId& machine, const std::string& name) const {
    Time until{};
    if (entries_.empty()) return until;
    for (const std::string& of : {std::string(), name}) {
      const auto found = entries_.find({machine, of});
      until = found == entries_.end() ? until : std::max(until, found->second.until);
    }
    return until;
  }

  static constexpr Time first = seconds(60);
  static constexpr Time longest = seconds(64 * 60);

 private:
  struct Entry {
    Time until{};   ///< end of the delay
    Time length{};  ///< of the latest delay
  };
  /// An empty name stands for the whole machine.
  std::map<std::pair<MachineId, std::string>, Entry> entries_;
};

}  // namespace parray::coordinator
