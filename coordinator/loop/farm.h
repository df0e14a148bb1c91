#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/log/logger.h"
#include "coordinator/disputes/machines.h"
#include "coordinator/jobs/job.h"
#include "coordinator/jobs/job_index.h"
#include "coordinator/jobs/log_budget.h"
#include "coordinator/loop/bulk_ledger.h"
#include "coordinator/loop/coordinator_options.h"
#include "coordinator/loop/farm_watch.h"
#include "coordinator/loop/job_thread.h"
#include "coordinator/loop/scene_service.h"
#include "coordinator/loop/worker_registry.h"
#include "coordinator/store/store.h"
#include "proto/actor.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// Counts of events since the start.
struct Tally {
  std::uint64_t samples = 0;   ///< merged for the first time
  std::uint64_t granted = 0;   ///< leases
  std::uint64_t accepted = 0;  ///< results; the next three also count results
  std::uint64_t duplicate = 0;
  std::uint64_t stale = 0;
  std::uint64_t mismatch = 0;
  std::uint64_t failed = 0;     ///< leases that a worker could not trace
  std::uint64_t malformed = 0;  ///< messages and results that were refused or dropped
  std::uint64_t lost = 0;       ///< workers that left without `bye`
  std::uint64_t done = 0;       ///< jobs that ended as done; the next two also count jobs
  std::uint64_t failed_jobs = 0;
  std::uint64_t cancelled = 0;
  double queue_seconds = 0;  ///< sum of the times that jobs waited from queueing to a lease
  std::uint64_t begun = 0;   ///< number of the times in queue_seconds
};

/// The state that the parts of a coordinator share: jobs, workers, time and outgoing messages.
/// Plain data with a few services on it; every rule belongs to one of the parts: WorkerDesk,
/// JobBook, LeaseDesk, DisputeDesk, ClientRequests, WorkerLogs. Not thread-safe.
struct Farm {
  /// `kept_in`: the store; null: nothing outlives the process. `tasks` runs tasks on the store; it
  /// must be destroyed before the parts whose completions it calls.
  Farm(CoordinatorOptions options_of_farm, Store* kept_in,
       std::shared_ptr<spdlog::logger> log_of_farm, JobThread& tasks);

  /// Adds a message to the outbox.
  void send(const PeerId& peer, Message message);
  /// Answers a request with an error. `status`: the client's exit status.
  void fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                    const std::string& message);
  /// The number of a lease as log lines show it: from 1 in each job and process.
  [[nodiscard]] Epoch lease_number(Epoch epoch) const { return epoch - options.first_epoch + 1; }
  /// Converts a time of the loop to seconds since 1970, by the system's clock at the first tick.
  [[nodiscard]] double since_1970(Time at) const { return wall_zero + to_seconds(at); }
  /// Returns seconds since 1970 by the system's clock, for records; 1 if there is no clock.
  [[nodiscard]] double wall_now() const { return std::max(options.wall_clock(), 1.0); }
  /// Seconds for which coordinators have served this state.
  [[nodiscard]] double uptime() const;

  /// Notes an event for the operator of the farm.
  void announce(FarmEventKind kind, const std::string& worker, const std::string& text);
  /// Counts the end of a job and notes it for the operator, as FarmWatch::note() does.
  void announce_end(const Job& job);
  /// Notes that a job gets its first lease since it was queued.
  void note_begun(Job& job);
  /// Notes the state of the farm if ten seconds have passed.
  void note_history();
  /// Returns why no worker of this name is connected, as an error message. It says when the worker
  /// left, if that was within the last hour.
  [[nodiscard]] std::string why_no_worker(const std::string& name);

  /// Finds a job by its number. Null: none has it.
  Job* job_of(JobId id);
  /// Finds a job whose work still has this generation. Null: it ended or began again.
  Job* job_at_work(JobId id, std::uint64_t generation);
  /// Adds a line to the history of a job.
  void note(Job& job, const std::string& what) { job.record.note(options.wall_clock(), what); }
  /// Gives the record of a job to the job thread, which stores it. Does nothing for a job that is
  /// finishing: the job thread has its last record already.
  void keep(const Job& job);
  /// Calls `then` in the loop when the store has committed all that was given to the job thread.
  /// Without a store, calls it at once.
  void when_kept(std::function<void()> then);
  /// For tasks that answer a client: if a task throws, the client gets the error.
  [[nodiscard]] JobThread::Guarded for_client(const PeerId& peer, std::uint64_t request,
                                              const std::string& doing);
  /// For tasks without a recipient: if a task throws, the log gets the error.
  [[nodiscard]] JobThread::Guarded for_log(const std::string& doing);

  const CoordinatorOptions options;
  Store* const store;
  std::shared_ptr<spdlog::logger> log;
  JobThread& job_thread;
  LogBudget warnings;
  LogBudget arrivals;  ///< log lines of workers that join or leave
  WorkerRegistry workers;
  SceneService scenes;
  std::map<JobId, Job> jobs;
  JobIndex index;           ///< of `jobs`
  std::set<JobId> at_work;  ///< jobs with JobWork
  Machines machines;
  BulkLedger bulk;            ///< pictures, journals and scenes on their way to clients
  BulkLedger log_pictures;    ///< the picture that the job thread makes from a log
  BulkLedger scenes_waiting;  ///< scenes of submits that are not acknowledged yet
  Tally tally;
  FarmWatch watch;
  std::vector<Delivery> outbox;
  Sender sender;                    ///< of the current message
  Time now{};                       ///< of the current turn
  Time began = never;               ///< the first tick
  double wall_zero = 0;             ///< seconds since 1970 when `now` was 0; set by the first tick
  double uptime_before = 0;         ///< seconds that earlier coordinators served this state
  double price = 1e-7;              ///< thread-seconds per sample of the latest results
  std::string storage;              ///< why the store cannot commit; empty: it can
  Time queue_again_at{};            ///< when the queue must be built again
  std::uint64_t queue_changes = 0;  ///< how many times jobs were added, ended or changed
  Time grant_again_at = never;      ///< when a worker that was denied leases may get some
  bool grants_due = true;           ///< something changed since the last round of grants
};

}  // namespace parray::coordinator
