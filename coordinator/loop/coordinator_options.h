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

struct CoordinatorOptions {
  /// How often a worker says that it is alive. Shorter finds losses sooner, longer saves messages.
  Time heartbeat = seconds(1);
  /// Without a word for this long a worker is lost. At least a few heartbeats.
  Time silence = seconds(5);
  /// Of up to so many workers. Of up to n times as many both are n times as long, as long as a
  /// lease is still heard of three times before its deadline.
  std::size_t heartbeat_workers = 1000;
  /// A lease whose holder traces nothing for this long is taken back. Longer than the dearest
  /// millisecond-sized piece of work takes on a slow, loaded machine.
  Time lease_timeout = seconds(10);
  /// A worker holds two leases, and the next user in turn waits for these. A worker returns a part
  /// of a lease that takes twice the longest.
  LeaseLength lease_length{0.02, 0.5};
  /// Workers are told to look elsewhere when nothing can be committed for this long.
  Time release_after = never;
  std::size_t max_workers = 4096;
  Limits limits{};
  /// Bytes for pictures under way and, where no store keeps them, scenes and finished pictures.
  std::uint64_t memory = std::uint64_t{8} << 30;
  /// A job's time limit counts from when it was submitted, not from its first lease.
  bool waiting_counts = false;
  /// A job fails when so many different workers have failed at the same cells.
  std::uint32_t max_failures = 3;
  /// Which leases are traced a second time.
  CheckPolicy::Options checks{};
  /// Even random numbers in [0, 1), which decide who checks what, and no bits. Null: random_device.
  std::function<double()> random{};
  /// Decides where two machines returned different bits. Null: such jobs are held.
  std::shared_ptr<Referee> referee{};
  RefereeDesk::Options refereeing{};
  /// Where the epochs of every job begin. Another for every life of a coordinator, far from all
  /// others: a worker may still have a result for the one before.
  Epoch first_epoch = 1;
  /// Who says how far a job's denoised picture is, if it is to be the target: only whoever traces
  /// can. Null: nobody, and such jobs are refused.
  std::function<PictureJudge(const JobRecord&)> judge_of{};
  /// trace_fingerprint() of this build; workers must have the same.
  std::string fingerprint;
  /// Seconds since 1970, for a job's history. Any thread.
  std::function<double()> wall_clock = [] { return 0.0; };
  JobThread::Options job_thread{};
};

}  // namespace parray::coordinator
