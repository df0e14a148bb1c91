#pragma once

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
  bool by_loss = false;  ///< the worker was lost and did not report the failure itself
  bool excused = false;  ///< the network may have caused the loss
};

/// A worker that could get a lease now.
struct AbleWorker {
  MachineId machine;
  TracerKey worker = 0;
};

/// Collects the failures at one job and decides whether the job is at fault.
///
/// A job is at fault if no machine can trace it, or if no machine can trace certain cells of it. A
/// machine has failed at a job when each of its workers has failed, or when at least two more of
/// its workers have been lost than it has now. (A worker that dies with every lease returns as a
/// new process each time.) A machine that has traced other cells of the job has failed at certain
/// cells after one failure there. While some machine that may get a lease has not failed, only
/// machines that have traced other cells count.
///
/// Not thread-safe. Reads no clock.
class JobFailures {
 public:
  void add(Failure failure) { all_.push_back(std::move(failure)); }
  /// Notes that a result of this machine was accepted.
  void note_success(const MachineId& machine) { succeeded_.insert(machine); }
  [[nodiscard]] bool any_success() const { return !succeeded_.empty(); }
  [[nodiscard]] bool has_succeeded(const MachineId& machine) const {
    return succeeded_.contains(machine);
  }
  [[nodiscard]] const std::vector<Failure>& all() const { return all_; }

  /// Notes that a worker has joined. Removes the losses of the same process, because it was not
  /// lost. Excused losses of another process of the same name or machine are then no longer
  /// excused; returns those.
  std::vector<Failure> note_joined(const MachineId& machine, TracerKey worker,
                                   const std::string& name);

  /// Decides whether the job is at fault after a failure at `range`. `able`: the workers that could
  /// get a lease of it. `most`: number of failed machines that is enough. If all able machines
  /// have failed but are fewer, each needs two failures for each worker. Returns how many machines
  /// failed, for people; nothing if the job is not at fault.
  [[nodiscard]] std::optional<std::string> verdict(const CellRange& range,
                                                   const std::vector<AbleWorker>& able,
                                                   std::uint32_t most) const;

 private:
  std::vector<Failure> all_;
  std::set<MachineId> succeeded_;
};

}  // namespace parray::coordinator
