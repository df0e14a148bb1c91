#include "coordinator/disputes/fault_findings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace parray::coordinator {

using nlohmann::json;

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

json FaultFindings::to_json() const {
  json list = json::array();
  for (const FaultFinding& finding : list_) {
    list.push_back(
        {{"number", finding.number}, {"machine", finding.machine}, {"worker", finding.worker}});
  }
  return list;
}

FaultFindings FaultFindings::from_json(const json& list) {
  FaultFindings fault_findings;
  for (const json& entry : list) {
    fault_findings.list_.push_back({entry.at("number").get<std::uint64_t>(),
                                    entry.at("machine").get<std::uint64_t>(),
                                    entry.at("worker").get<std::string>()});
  }
  std::ranges::sort(fault_findings.list_, {}, &FaultFinding::number);
  return fault_findings;
}

RunError damaged_worker_note(std::string_view why) {
  return RunError(
      "the state's note \"workers\" (drained workers and faulty machines) is damaged: " +
      std::string(why) + ": put the state back from a backup");
}

}  // namespace parray::coordinator
