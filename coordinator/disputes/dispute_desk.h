#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <utility>

#include "coordinator/disputes/merged.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class JobBook;

/// Handles checks of results, disputes (two machines returned different bits for the same samples),
/// and machines that get no leases. A worker is barred if it gets no leases, because of a drain (an
/// administrator's command) or a quarantine (its machine returned wrong bits).
class DisputeDesk {
 public:
  DisputeDesk(Farm& farm, JobBook& job_book);

  // Checks and disputes (disputes.cpp).
  /// Decides whether an accepted lease is checked, and by which machine. The worker that traced the
  /// lease may have left.
  void draw_check(Job& job, const Merged& merged);
  /// Gives checks to other machines if the chosen machine has left or could not make them.
  void place_orphans(Job& job);
  /// Handles a result that was compared with merged cells. Opens a dispute if they differ.
  void compare_result(Job& job, const Merged& merged);
  /// Ends passes that waited only for checks and whose checks are done now.
  void look_after_checks();
  /// Handles answers of the referee and asks it the next question. Pauses jobs that must wait for
  /// its decision, and resumes jobs that no longer need to.
  void take_referee_turn(Time now);
  [[nodiscard]] RefereeDesk& referee() { return desk_; }
  [[nodiscard]] const RefereeDesk& referee() const { return desk_; }

  // Machines that get no leases (barred_machines.cpp).
  /// Notes that a worker joined. Bars it if its machine, name or host is barred.
  void note_joined(WorkerRecord& worker);
  /// Puts a machine into quarantine, for `reason`. In jobs in memory, other machines trace its
  /// cells again and repeat its checks. For other unfinished jobs see retract_later_faulty().
  void quarantine(TracerKey machine, const std::string& reason);
  /// Ends the quarantines whose time is over.
  void end_quarantines();
  /// Removes from a job the results of machines that were put into quarantine while the job had no
  /// picture in memory.
  void retract_later_faulty(Job& job);
  /// Returns the number of the latest finding (FaultFinding). A new job starts with it, because
  /// earlier findings do not concern it.
  [[nodiscard]] std::uint64_t latest_finding() const { return fault_findings_.latest(); }
  /// Bars the workers with the name `name`, or, if `host`, all workers of the host `name`, also
  /// those that join later. They finish the leases that they hold. `asker`: for the log. Call
  /// keep_worker_notes() afterwards.
  void drain(const std::string& name, bool host, const std::string& asker);
  /// Ends drains and quarantines, also of machines without a connected worker: if `host`, of the
  /// host `name`; otherwise of the workers, key or address `name`. Call keep_worker_notes()
  /// afterwards.
  void readmit(const std::string& name, bool host);
  /// Returns machines in quarantine without a connected worker, as worker maps of PROTOCOL.md.
  [[nodiscard]] nlohmann::json quarantined_elsewhere();
  /// Writes the barred workers and the findings to the store.
  void keep_worker_notes();
  /// Reads the barred workers and the findings from the store. Throws RunError if the note is
  /// damaged.
  void restore_worker_notes();

 private:
  struct CheckedAnswer;
  struct Retracted;
  [[nodiscard]] Time latest_return(const Job& job, const std::set<TracerKey>& not_by) const;
  void place_check(Job& job, LeaseTable::Check check);
  void keep_wanted(const Job& job, const CellRange& range);
  [[nodiscard]] RefereeCase case_of(const Job& job, double length) const;
  bool check_by_referee(Job& job, const CellRange& range, bool sole);
  void open_dispute(Job& job, const Merged& merged);
  void check_answer(RefereeDesk::Traced traced);
  void note_checked_answer(Job& job, const CheckedAnswer& checked);
  void hold_disputed_jobs(Time now);
  void retract(Job& job, const FaultFinding& finding);
  void note_retracted(Job& job, const Retracted& retracted);
  void apply_bars(WorkerRecord& worker);
  [[nodiscard]] std::string worker_of(TracerKey machine) const;

  Farm& farm_;
  JobBook& job_book_;
  QuarantineLedger quarantines_;
  FaultFindings fault_findings_;
  CheckPolicy checks_;
  RefereeDesk desk_;
  bool any_held_ = false;  ///< a job waits for the referee
  /// Drained workers: (false, name) or (true, host).
  std::set<std::pair<bool, std::string>> drained_;
};

}  // namespace parray::coordinator
