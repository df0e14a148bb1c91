#include "coordinator/loop/machine_id.h"

#include <xxhash.h>

#include <array>
#include <string_view>

namespace parray::coordinator {
namespace {

/// How text_of() names each MachineId::Kind.
constexpr std::array<std::string_view, 3> kind_words = {"worker ", "key ", "address "};

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
  const std::uint64_t kind = machine_key & 3;
  return kind < kind_words.size() ? static_cast<MachineId::Kind>(kind) : MachineId::Kind::process;
}

std::string text_of(const MachineId& machine) {
  return std::string(kind_words.at(static_cast<std::size_t>(machine.kind))) + machine.name;
}

}  // namespace parray::coordinator
