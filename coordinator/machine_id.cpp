#include "coordinator/machine_id.h"

#include <string_view>

namespace parray {
namespace {

/// An IPv4 address that arrived over IPv6 is the same machine's. A machine has many loopback
/// addresses.
std::string one_address_of(std::string_view address) {
  constexpr std::string_view mapped = "::ffff:";
  if (address.starts_with(mapped)) {
    address.remove_prefix(mapped.size());
  }
  return std::string(address.starts_with("127.") || address == "::1" ? "localhost" : address);
}

}  // namespace

MachineId machine_of(const Sender& sender, const std::string& worker) {
  if (sender.role == Role::worker && sender.name != shared_worker_key) {
    return {MachineId::Kind::key, sender.name};
  }
  if (sender.address.empty()) {
    return {MachineId::Kind::process, worker};
  }
  return {MachineId::Kind::address, one_address_of(sender.address)};
}

std::string text_of(const MachineId& machine) {
  switch (machine.kind) {
    case MachineId::Kind::key:
      return "key " + machine.name;
    case MachineId::Kind::address:
      return "address " + machine.name;
    case MachineId::Kind::process:
      break;
  }
  return "worker " + machine.name;
}

}  // namespace parray
