#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <utility>

#include "coordinator/disputes/check_policy.h"
#include "coordinator/disputes/fault_findings.h"
#include "coordinator/disputes/merged.h"
#include "coordinator/disputes/quarantine.h"
#include "coordinator/disputes/referee_desk.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class JobBook;

/// Checks of results, disputes between machines, and machines that get no leases.
class DisputeDesk {
 public:
  DisputeDesk(Farm& farm, JobBook& job_book);

  // Checks and disputes (disputes.cpp).
  /// Decides whether an accepted lease is traced a second time.
  void draw_check(Job& job, const Merged& merged);
  /// Gives checks whose machine has left or failed to others.
  void place_orphans(Job& job);
  /// Notes the comparison of cells that came again; opens a dispute if they differ.
  void compare_result(Job& job, const Merged& merged);
  /// Ends the passes that wait for checks only.
  void look_after_checks();
  void take_referee_turn(Time now);
  [[nodiscard]] RefereeDesk& referee() { return desk_; }
  [[nodiscard]] const RefereeDesk& referee() const { return desk_; }

  // Machines that get no leases (barred_machines.cpp).
  /// Notes a worker that joined, and bars it if its machine or name is barred.
  void greet(WorkerRecord& worker);
  /// Bars a machine. What it traced and checked in unfinished jobs is traced and checked again.
  void quarantine(TracerKey machine, const std::string& reason);
  void end_quarantines();
  /// Removes the results of machines that were put into quarantine while the job was not at work.
  void retract_later_faulty(Job& job);
  /// The number of the latest quarantine, for new jobs.
  [[nodiscard]] std::uint64_t latest_finding() const { return fault_findings_.latest(); }
  /// Bars a worker by name, or a host; they finish the leases that they hold.
  void drain(const std::string& name, bool host, const std::string& asker);
  /// Ends drains and quarantines of a worker's name, or of a host.
  void readmit(const std::string& name, bool host);
  /// Machines in quarantine without a connected worker, as worker maps of PROTOCOL.md.
  [[nodiscard]] nlohmann::json quarantined_elsewhere();
  void keep_worker_notes();
  /// Throws RunError if the state's note is damaged.
  void restore_worker_notes();

 private:
  struct Judged;
  struct Retracted;
  void place_check(Job& job, LeaseTable::Check check);
  [[nodiscard]] RefereeCase case_of(const Job& job, double length) const;
  bool check_by_referee(Job& job, const CellRange& range);
  void open_dispute(Job& job, const Merged& merged);
  void judge(RefereeDesk::Traced traced);
  void note_judged(Job& job, const Judged& judged);
  void hold_disputed_jobs(Time now);
  void retract(Job& job, const FaultFinding& finding);
  void note_retracted(Job& job, const Retracted& retracted);
  void bar_as_due(WorkerRecord& worker);
  [[nodiscard]] bool is_drained(const WorkerRecord& worker) const;
  [[nodiscard]] std::string worker_of(TracerKey machine) const;

  Farm& farm_;
  JobBook& job_book_;
  QuarantineLedger quarantines_;
  FaultFindings fault_findings_;
  CheckPolicy checks_;
  RefereeDesk desk_;
  bool any_held_ = false;                           ///< a job waits for the referee
  std::set<std::pair<bool, std::string>> drained_;  ///< workers by name, or (true) by host
};

}  // namespace parray::coordinator
