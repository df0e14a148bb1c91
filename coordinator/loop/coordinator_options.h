#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "coordinator/disputes/check_policy.h"
#include "coordinator/disputes/referee_desk.h"
#include "coordinator/jobs/job.h"
#include "coordinator/loop/job_thread.h"
#include "coordinator/loop/limits.h"
#include "proto/actor.h"

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

}  // namespace parray::coordinator
