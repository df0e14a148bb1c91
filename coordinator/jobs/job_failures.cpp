#include "coordinator/jobs/job_failures.h"

#include <algorithm>
#include <map>

namespace parray::coordinator {
namespace {

/// The failures of one machine.
struct MachineFailures {
  std::size_t failures = 0;
  std::size_t deaths = 0;
  std::set<TracerKey> workers{};  ///< workers that have failed
};

using FailedMachines = std::map<MachineId, MachineFailures>;

bool overlap(const CellRange& a, const CellRange& b) { return a.begin < b.end && b.begin < a.end; }

/// Returns whether a machine with the able workers `workers` has failed: each of them has, or at
/// least two more processes have died there than it has workers.
bool has_failed(const MachineFailures& machine, const std::set<TracerKey>& workers) {
  return machine.deaths >= 2 + workers.size() || std::ranges::includes(machine.workers, workers);
}

}  // namespace

std::vector<Failure> JobFailures::note_joined(const MachineId& machine, TracerKey worker,
                                              const std::string& name) {
  std::erase_if(all_, [&](const Failure& f) { return f.by_loss && f.worker == worker; });
  std::vector<Failure> deaths;
  for (Failure& failure : all_) {
    if (failure.excused && (failure.machine == machine || failure.name == name)) {
      failure.excused = false;
      deaths.push_back(failure);
    }
  }
  return deaths;
}

std::optional<std::string> JobFailures::verdict(const CellRange& range,
                                                const std::vector<AbleWorker>& able,
                                                std::uint32_t most) const {
  FailedMachines same_cells;  // failures at the same cells
  FailedMachines
      any_cells;  // failures at any cells, without losses elsewhere that a network may explain
  std::size_t trusted = 0;
  for (const Failure& failure : all_) {
    const bool same = overlap(failure.range, range);
    for (FailedMachines* machines : {&same_cells, &any_cells}) {
      if (same || (machines == &any_cells && !failure.excused)) {
        MachineFailures& machine = (*machines)[failure.machine];
        ++machine.failures;
        machine.deaths += failure.by_loss ? 1 : 0;
        machine.workers.insert(failure.worker);
      }
    }
  }
  for (const auto& [machine, failed] : same_cells) trusted += has_succeeded(machine) ? 1 : 0;
  const FailedMachines& counted = any_success() ? same_cells : any_cells;
  std::map<MachineId, std::set<TracerKey>> present;
  for (const AbleWorker& worker : able) present[worker.machine].insert(worker.worker);
  bool all = true;
  bool all_twice = !present.empty();
  for (const auto& [machine, workers] : present) {
    const auto found = counted.find(machine);
    all = all && found != counted.end() && has_failed(found->second, workers);
    all_twice = all_twice && found != counted.end() && found->second.failures >= 2 * workers.size();
  }
  const auto text = [](std::size_t machines, const char* twice) {
    return std::to_string(machines) + (machines == 1 ? " machine" : " machines") + twice;
  };
  if (trusted >= most) return text(trusted, "");
  if (all && counted.size() >= most) return text(counted.size(), "");
  if (all && all_twice) return text(counted.size(), ", twice");
  return std::nullopt;
}

}  // namespace parray::coordinator
