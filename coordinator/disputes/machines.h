#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "coordinator/loop/machine_id.h"
#include "proto/clock.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// Remembers the machines that this process has seen, connected or not, up to a limit. Not
/// thread-safe.
class Machines {
 public:
  struct Known {
    std::string name;          ///< text_of() the machine, for people
    std::string worker;        ///< name of the worker that joined last
    std::string host;          ///< of that worker
    std::uint64_t leases = 0;  ///< number of leases accepted from it
    Time lost = Time::min();   ///< when a worker there last disappeared without `bye`; min: never
  };
  /// Notes that a worker has joined from a machine. Beyond the limit, forgets the machine with the
  /// smallest key. If that machine returns, it counts as new.
  void note(const MachineId& machine, const msg::Hello& hello) {
    Known& known = known_[machine_key(machine)];
    known.name = text_of(machine);
    known.worker = hello.name;
    known.host = hello.host;
    constexpr std::size_t most = 100000;
    if (known_.size() > most) known_.erase(known_.begin());
  }
  /// Notes that a worker of a machine was lost. It may return.
  void note_lost(std::uint64_t machine, Time now) { known_[machine].lost = now; }
  /// Returns when a machine that may check a lease last lost a worker; Time::min() if none has.
  /// `may_check` receives the key of a machine.
  [[nodiscard]] Time last_lost(const auto& may_check) const {
    Time last = Time::min();
    for (const auto& [machine, known] : known_) {
      if (known.lost > last && may_check(machine)) last = known.lost;
    }
    return last;
  }
  /// Counts an accepted lease of a machine. Returns the number of its earlier accepted leases.
  std::uint64_t count_lease(std::uint64_t machine) { return known_[machine].leases++; }
  /// Returns what is known of a machine. Empty texts: no worker has joined from it, or it was
  /// forgotten.
  [[nodiscard]] Known find(std::uint64_t machine) const {
    const auto found = known_.find(machine);
    return found == known_.end() ? Known{} : found->second;
  }

 private:
  std::map<std::uint64_t, Known> known_;
};

}  // namespace parray::coordinator
