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
#include "coordinator/disputes/check_policy.h"
#include "coordinator/disputes/machines.h"
#include "coordinator/disputes/referee_desk.h"
#include "coordinator/jobs/job.h"
#include "coordinator/jobs/job_index.h"
#include "coordinator/jobs/log_budget.h"
#include "coordinator/loop/bulk_ledger.h"
#include "coordinator/loop/farm_watch.h"
#include "coordinator/loop/job_thread.h"
#include "coordinator/loop/limits.h"
#include "coordinator/loop/scene_service.h"
#include "coordinator/loop/worker_registry.h"
#include "coordinator/store/store.h"
#include "proto/actor.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// Settings of a coordinator.
struct CoordinatorOptions {
  /// Time between two heartbeats of a worker. Shorter finds losses sooner; longer saves messages.
  Time heartbeat = seconds(1);
  /// Time without a message after which a worker counts as lost. At least a few heartbeats.
  Time silence = seconds(5);
  /// Number of workers for which `heartbeat` and `silence` are meant. With up to n times as many
  /// workers (n = 2, 3, ...), both are n times as long. n grows only as long as three heartbeats
  /// fit into `lease_timeout`. At most, `heartbeat` becomes 60 s and `silence` 600 s.
  std::size_t heartbeat_workers = 1000;
  /// The coordinator takes a lease back if its holder traces nothing for this long. Longer than the
  /// most expensive cell takes on a slow, loaded machine. Preparing a job counts as tracing, but at
  /// most for 30 times this long.
  Time lease_timeout = seconds(10);
  /// Shortest and longest duration that a lease should have, in seconds. A worker holds two leases,
  /// and the next user in turn waits until it has traced them. If a lease takes twice the longest
  /// duration, the worker returns the cells that it has traced and gives the others back. With
  /// thousands of workers the longest is larger: a second per 4000 workers.
  LeaseLength lease_length{0.02, 0.5};
  /// If the store can commit nothing for this long, the coordinator sends `bye` to its workers, so
  /// that they try the standby.
  Time release_after = never;
  std::size_t max_workers = 4096;
  Limits limits{};
  /// Bytes for unfinished pictures and their scenes, the referee, and for answers and submits that
  /// are not completely sent or received.
  /// Without a store also for all other scenes and for finished pictures.
  std::uint64_t memory = std::uint64_t{8} << 30;
  /// Whether a job's time limit counts from its submit instead of its first lease.
  bool waiting_counts = false;
  /// Number of machines that must fail before a job fails, unless the job has its own number.
  /// JobFailures says which machines count, and when fewer suffice.
  std::uint32_t max_failures = 3;
  /// Called with the reason before a machine gets no more leases because it returned wrong bits. An
  /// exception ends the coordinator. Null, or the function returns: the coordinator goes on
  /// with other machines.
  std::function<void(const std::string& reason)> on_quarantine{};
  /// Which leases a second machine traces again.
  CheckPolicy::Options checks{};
  /// Uniform random numbers in [0, 1). They select leases to check and do not influence pictures.
  /// Null: std::random_device.
  std::function<double()> random{};
  /// Decides which result is right if two machines return different bits. Null: such jobs pause.
  std::shared_ptr<Referee> referee{};
  RefereeDesk::Options refereeing{};
  /// First epoch of every job. Each process of parray-coordinator uses a random number of up to 62
  /// bits. A worker may still return a result of the previous process, and its epoch must not occur
  /// again.
  Epoch first_epoch = 1;
  /// Makes the function that estimates the error of a job's denoised picture, for error targets
  /// that apply to the denoised picture. Null: the coordinator refuses such jobs.
  std::function<PictureJudge(const JobRecord&)> judge_of{};
  /// trace_fingerprint() of this build. Workers must have the same.
  std::string fingerprint;
  /// Returns seconds since 1970, for a job's history. Any thread may call it.
  std::function<double()> wall_clock = [] { return 0.0; };
  JobThread::Options job_thread{};
};

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
  /// Gives the job thread a task that answers a client. If it throws, the client gets the error.
  void for_client(const PeerId& peer, std::uint64_t request, const std::string& doing,
                  JobThread::Task task);
  /// Gives the job thread a task without a recipient. If it throws, the log gets the error.
  void for_log(const std::string& doing, JobThread::Task task);

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
