#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "coordinator/loop/machine_id.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Holds leases back from workers that fail where others succeed: for 1, 2, 4 ... minutes, 64 at
/// most. A success begins anew.
///
/// A worker is known by machine and name. A machine of which no worker succeeds is held back as a
/// whole, so that a new name does not help.
///
/// Plain state: `now` is an argument. One thread.
class Backoff {
 public:
  /// The worker has failed at something that another one has traced. `whole`: no worker of its
  /// machine has traced any of that. Nothing happens while leases are held back already.
  void note_failure(Time now, const MachineId& machine, const std::string& name, bool whole);
  /// True: something was held against the worker, and no longer is.
  bool note_success(const MachineId& machine, const std::string& name) {
    return !entries_.empty() && forgive(machine, name);
  }
  /// Leases again at once. True: something was held against the worker.
  bool forgive(const MachineId& machine, const std::string& name);

  /// When the worker may have leases again. Not after `now`: it may.
  [[nodiscard]] Time until(const MachineId& machine, const std::string& name) const;

  static constexpr Time first = seconds(60);
  static constexpr Time longest = seconds(64 * 60);

 private:
  struct Entry {
    Time until{};
    Time length{};
  };
  /// An empty name: the whole machine.
  std::map<std::pair<MachineId, std::string>, Entry> entries_;
};

}  // namespace parray::coordinator
