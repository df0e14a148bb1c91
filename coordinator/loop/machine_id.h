#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "proto/keys.h"

namespace parray::coordinator {

/// Identifies the machine of a worker by facts that the worker cannot choose: its key or address.
/// It stays the same if the worker restarts or takes another name. A worker inside the
/// coordinator's process is identified by its name.
struct MachineId {
  enum class Kind : std::uint8_t {
    process,  ///< a worker inside the coordinator's process; `name` is the worker's name
    key,  ///< `name` is the name of the worker's own key (parray keygen DIR --role worker --name
          ///< NAME)
    address,  ///< `name` is the address from which the coordinator sees the worker
  };
  Kind kind = Kind::process;
  std::string name;

  std::strong_ordering operator<=>(const MachineId&) const = default;
};

/// Returns the machine of the worker named `worker`, which sent a message as `sender`. Many
/// machines may share worker.key, so then the address identifies them. All loopback addresses are
/// one machine.
MachineId machine_of(const Sender& sender, const std::string& worker);

/// Returns a number that stands for the machine in journals, leases and quarantines. It is the same
/// in every process of a coordinator. Its two lowest bits hold the kind.
std::uint64_t machine_key(const MachineId& machine);
/// Returns the kind of a machine from its number.
MachineId::Kind kind_of(std::uint64_t machine_key);

/// Returns a text for people: "key NAME", "address 10.0.0.1" or "worker NAME".
std::string text_of(const MachineId& machine);

}  // namespace parray::coordinator
