#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "proto/keys.h"

namespace parray::coordinator {

/// Names the machine of a worker by what the coordinator knows itself. Nothing in it is chosen by
/// the worker, unless the worker is part of the coordinator's process. So it stays the same when a
/// worker is started again or takes another name.
struct MachineId {
  enum class Kind : std::uint8_t {
    process,  ///< a worker inside the coordinator's process; `name` is the worker's
    key,      ///< `name` is that of its own key (parray keygen DIR --worker NAME)
    address,  ///< `name` is its address as the coordinator sees it
  };
  Kind kind = Kind::process;
  std::string name;

  std::strong_ordering operator<=>(const MachineId&) const = default;
};

/// The machine of the worker `worker` whose message came from `sender`. The key worker.key is
/// shared by many machines, so the address counts for it. All addresses of the loopback network
/// are one machine.
MachineId machine_of(const Sender& sender, const std::string& worker);

/// A number that stands for the machine in rows, leases and quarantines, in every life of a
/// coordinator. Its two lowest bits are the kind.
std::uint64_t machine_key(const MachineId& machine);
MachineId::Kind kind_of(std::uint64_t machine_key);

/// For people: "key NAME", "address 10.0.0.1" or "worker NAME".
std::string text_of(const MachineId& machine);

}  // namespace parray::coordinator
