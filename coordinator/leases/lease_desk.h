#pragma once

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

  /// Handle a message from the worker `peer`: the result of a lease, or the report that it could
  /// not trace one.
  void on(Time now, const PeerId& peer, msg::Result& m);
  void on(Time now, const PeerId& peer, msg::Failed& m);

  /// Grants leases, one at a time, in turn to the workers that hold fewer leases than they want
  /// (msg::Hello::capacity). Does nothing while the store cannot commit, while thousands of tasks
  /// wait for the job thread, or if no event since the last call can have changed the outcome.
  /// False: it has granted as many leases as one call may. Call it again in the loop's next turn.
  bool grant_leases(Time now);
  /// Takes the leases whose deadlines have passed from their holders.
  void expire_leases(Time now);
  /// Returns the next deadline of a lease; `never` if no worker holds one.
  [[nodiscard]] Time next_deadline() const;
  /// Notes that `failure` ended a lease. Fails the job if the job is at fault (JobFailures). Gives
  /// the failing worker no leases for some time (Backoff) if another connected worker has traced a
  /// part of the job and the failure is not excused (Failure::excused).
  void note_failure(Time now, Job& job, Failure failure);
  /// Call it when `worker` has joined. Decides what became of lost workers with its machine or
  /// name. If `worker` is the same process as a lost worker, only the connection was lost. If it is
  /// another process, the lost worker has died, which counts as its failure.
  void check_losses(Time now, const WorkerRecord& worker);
  /// Tells the worker registry which failing workers get no leases at present, and until when.
  void hold_back(Time now);
  /// Ends the delays of a worker and of its machine. Call hold_back() afterwards, so that they get
  /// leases again.
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
  FairQueue queue_;  ///< the open jobs, in the order in which they are served
  Backoff backoff_;
  PeerId granted_last_;  ///< the worker that got the last lease
};

}  // namespace parray::coordinator
