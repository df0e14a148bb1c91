#include "coordinator/disputes/fault_findings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace parray::coordinator {

using nlohmann::json;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FaultFinding, number, machine, worker)

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
