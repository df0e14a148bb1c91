#include "coordinator/disputes/machines.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace parray::coordinator {

using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FaultFinding, number, machine, worker)
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

std::size_t QuarantineLedger::readmit(std::string_view name, bool host) {
  return std::erase_if(machines_, [&](const auto& entry) {
    const Quarantine& quarantine = entry.second;
    return host ? quarantine.host == name
                : quarantine.name == name || quarantine.worker == name ||
                      quarantine.name == "key " + std::string(name) ||
                      quarantine.name == "address " + std::string(name);
  });
}

std::size_t QuarantineLedger::expire(double now) {
  return std::erase_if(machines_, [&](const auto& entry) {
    return entry.second.until != 0 && entry.second.until <= now;
  });
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

FaultFinding FaultFindings::add(std::uint64_t machine, std::string worker) {
  const std::uint64_t number = latest() + 1;
  std::erase_if(list_, [machine](const FaultFinding& c) { return c.machine == machine; });
  if (list_.size() == most) list_.erase(list_.begin());
  list_.push_back({number, machine, std::move(worker)});
  return list_.back();
}

std::vector<FaultFinding> FaultFindings::after(std::uint64_t number) const {
  return {std::ranges::upper_bound(list_, number, {}, &FaultFinding::number), list_.end()};
}

json FaultFindings::to_json() const { return list_; }

FaultFindings FaultFindings::from_json(const json& list) {
  FaultFindings fault_findings;
  list.get_to(fault_findings.list_);
  std::ranges::sort(fault_findings.list_, {}, &FaultFinding::number);
  return fault_findings;
}

RunError damaged_worker_note(std::string_view why) {
  return RunError(
      "the state's note \"workers\" (drained workers and faulty machines) is damaged: " +
      std::string(why) + ": put the state back from a backup");
}

}  // namespace parray::coordinator
