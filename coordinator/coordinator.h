#pragma once

#include <spdlog/logger.h>

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/job.h"
#include "coordinator/store.h"
#include "proto/actor.h"
#include "proto/messages.h"

namespace parray {

struct CoordinatorOptions {
  /// How often a worker says that it is alive. Shorter finds losses sooner, longer saves messages.
  Time heartbeat = seconds(1);
  /// Without a word for this long a worker is lost. At least a few heartbeats.
  Time silence = seconds(5);
  /// A lease whose holder traces nothing for this long is taken back. Longer than the dearest
  /// millisecond-sized piece of work takes on a slow, loaded machine.
  Time lease_timeout = seconds(10);
  /// Weighted leases are between these two long, by measured speed: shorter costs messages, longer
  /// costs more when a worker is lost, and makes progress jerk.
  Time shortest_lease = milliseconds(20);
  Time longest_lease = seconds(1);
  std::size_t max_jobs = 1000;
  std::size_t max_workers = 4096;
  /// trace_fingerprint() of this build; workers must have the same.
  std::string fingerprint;
};

/// The coordinator's side of PROTOCOL.md: owns jobs, framebuffers and leases. Plain state, driven
/// by one thread; no clock and no I/O but through the store.
class Coordinator final : public Actor {
 public:
  /// Takes up the jobs that `store` still has. Throws RunError when it cannot be read.
  Coordinator(CoordinatorOptions options, Store& store, std::shared_ptr<spdlog::logger> log);

  void receive(Time now, Delivery delivery) override;
  Time tick(Time now) override;
  std::vector<Delivery> take_outbox() override;

  /// Tells every worker goodbye; the next outbox carries the messages.
  void leave(const std::string& reason);

  /// What has happened since the start: leases granted, results by verdict, messages dropped.
  struct Tally {
    std::uint64_t granted = 0;
    std::uint64_t accepted = 0;
    std::uint64_t duplicate = 0;
    std::uint64_t stale = 0;
    std::uint64_t mismatch = 0;
    std::uint64_t malformed = 0;
  };
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  struct WorkerRecord {
    WorkerId id = 0;
    PeerId peer;
    msg::Hello hello;
    Time last_heard{};
    std::uint64_t traced = 0;
    Time traced_at{};  ///< when `traced` last grew
    Time preparing_since = never;
    std::string scene_sent;  ///< digest of the last one, and when it may be sent again
    Time scene_again_at{};
    double samples_per_second = 0;  ///< measured; 0: not yet
    std::uint64_t accepted = 0;     ///< results
    bool quarantined = false;
  };

  /// Samples a second.
  struct FarmSpeed {
    double per_thread;  ///< of the workers that have been measured
    double all;
  };

  // Messages of workers (coordinator.cpp).
  void on(Time now, const PeerId& peer, msg::Hello& m);
  void on(Time now, const PeerId& peer, msg::Heartbeat& m);
  void on(Time now, const PeerId& peer, msg::NeedScene& m);
  void on(Time now, const PeerId& peer, msg::Result& m);
  void on(Time now, const PeerId& peer, msg::Bye& m);
  // Messages of clients (clients.cpp).
  void on(Time now, const PeerId& peer, msg::Submit& m);
  void on(Time now, const PeerId& peer, msg::ListJobs& m);
  void on(Time now, const PeerId& peer, msg::ShowJob& m);
  void on(Time now, const PeerId& peer, msg::Cancel& m);
  void on(Time now, const PeerId& peer, msg::Fetch& m);
  void on(Time now, const PeerId& peer, msg::ListWorkers& m);
  template <typename Other>
  void on(Time now, const PeerId& peer, Other& m);  // not for a coordinator

  void send(const PeerId& peer, const Message& message);
  void send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                    const std::string& message);

  // Workers and leases.
  WorkerRecord* worker_at(const PeerId& peer);
  void note_progress(Time now, WorkerRecord& worker, const msg::Heartbeat& heartbeat);
  void lose_worker(const PeerId& peer, const std::string& why);
  void merge_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result);
  void grant_leases(Time now);
  bool grant_one(Time now, WorkerRecord& worker, const FarmSpeed& farm);
  bool grant_from(Time now, WorkerRecord& worker, Job& job, const FarmSpeed& farm, bool may_copy);
  [[nodiscard]] FarmSpeed farm_speed() const;
  [[nodiscard]] Asker asker_for(const WorkerRecord& worker, const Job& job,
                                const FarmSpeed& farm) const;
  void quarantine(WorkerRecord& worker);
  void expire_leases(Time now);

  // Jobs (jobs.cpp).
  Job* job_of(JobId id);
  void restore_jobs();
  void finish_job(Time now, Job& job);
  void finish_complete_jobs(Time now);
  void close_job(Job& job, JobState state, const std::string& reason);
  void make_room_for_job();
  void sort_open_jobs();

  const CoordinatorOptions options_;
  Store& store_;
  std::shared_ptr<spdlog::logger> log_;
  std::map<PeerId, WorkerRecord> workers_;
  std::map<JobId, Job> jobs_;
  std::vector<Job*> open_jobs_;  ///< of jobs_: those with work left, by priority, then by age
  WorkerId next_worker_ = 1;
  JobId next_job_ = 1;
  Tally tally_;
  std::vector<Delivery> outbox_;
  bool store_dirty_ = false;
};

}  // namespace parray
