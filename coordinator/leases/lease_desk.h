#pragma once

#include <string>
#include <vector>

#include "coordinator/disputes/merged.h"
#include "coordinator/jobs/fair_queue.h"
#include "coordinator/loop/backoff.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class DisputeDesk;
class JobBook;
class WorkerDesk;

/// Grants leases to workers and handles their results and failures.
class LeaseDesk {
 public:
  LeaseDesk(Farm& farm, JobBook& job_book, DisputeDesk& disputes, WorkerDesk& worker_desk)
      : farm_(farm), job_book_(job_book), disputes_(disputes), worker_desk_(worker_desk) {}

  /// Handle a result or a failure of a lease.
  void on(Time now, const PeerId& peer, msg::Result& m);
  void on(Time now, const PeerId& peer, msg::Failed& m);

  /// Grants leases to the workers with room, one at a time in turn. Does nothing if nothing has
  /// changed. False: more leases remain than one turn of the loop has time for.
  bool grant_leases(Time now);
  /// Takes back the leases whose holders made no progress in time.
  void expire_leases(Time now);
  /// Returns the next deadline of a lease; `never` if no worker holds one.
  [[nodiscard]] Time next_deadline() const;
  /// Notes that `failure` ended a lease. Fails the job if no machine can trace these cells, and
  /// delays leases for a worker that fails where others succeed.
  void note_failure(Time now, Job& job, Failure failure);
  /// After a worker joined: decides whether earlier losses on its machine were deaths.
  void check_losses(Time now, const WorkerRecord& worker);
  /// Updates the registry with the delays of failing workers.
  void hold_back(Time now);
  /// Ends the delay of a failing worker.
  void forgive(const WorkerRecord& worker);

 private:
  void queue_open_jobs();
  bool grant_one(Time now, WorkerRecord& worker, bool& room);
  bool grant_from(Time now, WorkerRecord& worker, Job& job, bool copy);
  [[nodiscard]] static bool may_trace(Time now, const WorkerRecord& worker, const Job& job);
  void send_grant(WorkerRecord& worker, Job& job, const Lease& lease);
  void take_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result,
                   const LeaseTable::Arrived& arrived);
  void note_merged(Job& job, const Merged& merged);
  void revoke_copies(const Job& job, Epoch epoch, const std::vector<WorkerId>& holders);
  void note_accepted(Job& job, const Merged& merged);
  void note_success(Job& job, WorkerId id);

  Farm& farm_;
  JobBook& job_book_;
  DisputeDesk& disputes_;
  WorkerDesk& worker_desk_;
  FairQueue queue_;  ///< of the open jobs
  Backoff backoff_;
  PeerId granted_last_;  ///< the worker that got the last lease
};

}  // namespace parray::coordinator
