#include "coordinator/loop/machine_id.h"

#include <xxhash.h>

#include <string_view>

namespace parray::coordinator {
namespace {

/// Returns the same text for the IPv4 and IPv6 forms of an address, and for all loopback addresses.
std::string normalized_address(std::string_view address) {
  constexpr std::string_view mapped = "::ffff:";
  if (address.starts_with(mapped)) address.remove_prefix(mapped.size());
  return std::string(address.starts_with("127.") || address == "::1" ? "localhost" : address);
}

}  // namespace

MachineId machine_of(const Sender& sender, const std::string& worker) {
  if (sender.role == Role::worker && sender.name != shared_worker_key) {
    return {MachineId::Kind::key, sender.name};
  }
  if (sender.address.empty()) return {MachineId::Kind::process, worker};
  return {MachineId::Kind::address, normalized_address(sender.address)};
}

std::uint64_t machine_key(const MachineId& machine) {
  const auto kind = static_cast<std::uint64_t>(machine.kind);
  const std::uint64_t hash =
      XXH3_64bits_withSeed(machine.name.data(), machine.name.size(), kind + 1);
  return (hash & ~std::uint64_t{3}) | kind;
}

MachineId::Kind kind_of(std::uint64_t machine_key) {
  switch (machine_key & 3) {
    case static_cast<std::uint64_t>(MachineId::Kind::key): return MachineId::Kind::key;
    case static_cast<std::uint64_t>(MachineId::Kind::address): return MachineId::Kind::address;
    default: return MachineId::Kind::process;
  }
}

std::string text_of(const MachineId& machine) {
  switch (machine.kind) {
    case MachineId::Kind::key: return "key " + machine.name;
    case MachineId::Kind::address: return "address " + machine.name;
    case MachineId::Kind::process: break;
  }
  return "worker " + machine.name;
}

}  // namespace parray::coordinator
