#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/schedule/work_plan.h"
#include "coordinator/leases/result_collector.h"
#include "coordinator/loop/machine_id.h"

namespace parray::coordinator {

/// One failure: a worker could not trace a lease, or disappeared while it held the lease.
struct Failure {
  CellRange range;
  MachineId machine;
  TracerKey worker = 0;  ///< the process
  std::string name;      ///< of the worker
  std::string reason;
  bool by_loss = false;  ///< the worker did not say so: it was lost
  bool excused = false;  ///< it was lost, and perhaps it is the network's fault
};

/// A worker that could get a lease now.
struct AbleWorker {
  MachineId machine;
  TracerKey worker = 0;
};

/// The failures at one job, and whether they are the job's fault.
///
/// A job is at fault when no machine can trace it, or no machine certain cells of it. A machine has
/// failed at a job when each of its workers has, or when many of its workers have died: one that
/// dies with every lease comes back as another process each time. As long as a machine that has not
/// failed may still get a lease, only machines that have traced other cells of the job count.
///
/// Plain state, no clock. One thread.
class JobFailures {
 public:
  void add(Failure failure) { all_.push_back(std::move(failure)); }
  /// A result of that machine was accepted.
  void note_success(const MachineId& machine) { succeeded_.insert(machine); }
  [[nodiscard]] bool any_success() const { return !succeeded_.empty(); }
  [[nodiscard]] bool has_succeeded(const MachineId& machine) const {
    return succeeded_.contains(machine);
  }
  [[nodiscard]] const std::vector<Failure>& all() const { return all_; }

  /// A worker has joined. The same process as before: it was not lost, and its losses are struck
  /// out. Another process of the same name or machine: a loss there was a death. Returns these.
  std::vector<Failure> note_joined(const MachineId& machine, TracerKey worker,
                                   const std::string& name);

  /// Whether the job is at fault after a failure at `range`, given the workers that could get a
  /// lease of it. `most`: as --max-failures. Returns who has failed, for people.
  [[nodiscard]] std::optional<std::string> verdict(const CellRange& range,
                                                   const std::vector<AbleWorker>& able,
                                                   std::uint32_t most) const;

 private:
  std::vector<Failure> all_;
  std::set<MachineId> succeeded_;
};

}  // namespace parray::coordinator
