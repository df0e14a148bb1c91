#include "coordinator/disputes/quarantine.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace parray::coordinator {

using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Quarantine, machine, name, worker, host, reason, since, until)

bool QuarantineLedger::add(Quarantine quarantine) {
  const bool by_address = kind_of(quarantine.machine) == MachineId::Kind::address;
  quarantine.until = by_address ? quarantine.since + address_seconds : 0;
  const std::uint64_t machine = quarantine.machine;
  return machines_.emplace(machine, std::move(quarantine)).second;
}

const Quarantine* QuarantineLedger::find(std::uint64_t machine) const {
  const auto found = machines_.find(machine);
  return found == machines_.end() ? nullptr : &found->second;
}

std::vector<std::uint64_t> QuarantineLedger::readmit(std::string_view name, bool host) {
  std::vector<std::uint64_t> readmitted;
  std::erase_if(machines_, [&](const auto& entry) {
    const Quarantine& quarantine = entry.second;
    const bool named = host ? quarantine.host == name
                            : quarantine.name == name || quarantine.worker == name ||
                                  quarantine.name == "key " + std::string(name) ||
                                  quarantine.name == "address " + std::string(name);
    if (named) readmitted.push_back(entry.first);
    return named;
  });
  return readmitted;
}

std::vector<std::uint64_t> QuarantineLedger::expire(double now) {
  std::vector<std::uint64_t> ended;
  std::erase_if(machines_, [&](const auto& entry) {
    const bool over = entry.second.until != 0 && entry.second.until <= now;
    if (over) ended.push_back(entry.first);
    return over;
  });
  return ended;
}

json QuarantineLedger::to_json() const {
  json list = json::array();
  for (const auto& [machine, quarantine] : machines_) list.push_back(quarantine);
  return list;
}

QuarantineLedger QuarantineLedger::from_json(const json& list) {
  QuarantineLedger ledger;
  for (json entry : list) {
    entry.emplace("host", "");  // notes of earlier releases lack it
    auto quarantine = entry.get<Quarantine>();
    ledger.machines_[quarantine.machine] = std::move(quarantine);
  }
  return ledger;
}

}  // namespace parray::coordinator
