#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "coordinator/loop/machine_id.h"

namespace parray::coordinator {

/// What the coordinator remembers of machines that it has seen in this life, connected or not.
/// Plain state; one thread.
class Machines {
 public:
  struct Known {
    std::string name;          ///< text_of() the machine
    std::string worker;        ///< name of the worker that joined last
    std::uint64_t leases = 0;  ///< accepted
  };
  /// A worker has joined.
  void note(const MachineId& machine, const std::string& worker) {
    Known& known = known_[machine_key(machine)];
    known.name = text_of(machine);
    known.worker = worker;
    constexpr std::size_t most = 100000;  // any of them goes: it only counts as new again
    if (known_.size() > most) {
      known_.erase(known_.begin());
    }
  }
  /// Counts one more lease. Returns how many there were before.
  std::uint64_t count_lease(std::uint64_t machine) { return known_[machine].leases++; }
  /// Empty fields where the machine has not been seen in this life.
  [[nodiscard]] Known find(std::uint64_t machine) const {
    const auto found = known_.find(machine);
    return found == known_.end() ? Known{} : found->second;
  }

 private:
  std::map<std::uint64_t, Known> known_;
};

}  // namespace parray::coordinator
