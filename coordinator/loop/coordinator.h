#pragma once

#include <spdlog/logger.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "coordinator/disputes/check_policy.h"
#include "coordinator/disputes/convictions.h"
#include "coordinator/disputes/machines.h"
#include "coordinator/disputes/quarantine.h"
#include "coordinator/disputes/referee_desk.h"
#include "coordinator/jobs/fair_queue.h"
#include "coordinator/jobs/job.h"
#include "coordinator/jobs/job_index.h"
#include "coordinator/jobs/log_budget.h"
#include "coordinator/jobs/series.h"
#include "coordinator/loop/backoff.h"
#include "coordinator/loop/backroom.h"
#include "coordinator/loop/bulk_ledger.h"
#include "coordinator/loop/limits.h"
#include "coordinator/loop/scene_service.h"
#include "coordinator/loop/worker_registry.h"
#include "coordinator/store/store.h"
#include "proto/actor.h"
#include "proto/messages.h"

namespace parray::coordinator {

struct PictureFile;

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
  Backroom::Options backroom{};
};

/// The coordinator's side of PROTOCOL.md: owns jobs, pictures and leases. Plain state, driven by
/// one thread; what is heavy, and the store, is the backroom's.
class Coordinator final : public Actor {
 public:
  /// Takes up the jobs that `store` still has; null: nothing outlives the process. Throws RunError
  /// when it cannot be read.
  Coordinator(CoordinatorOptions options, Store* store, std::shared_ptr<spdlog::logger> log);

  void receive(Time now, Delivery delivery) override;
  Time tick(Time now, bool drained) override;
  std::vector<Delivery> take_outbox() override;

  /// Tells every worker goodbye; the next outbox carries the messages.
  void leave(const std::string& reason);

  /// What has happened since the start: samples that are new, leases granted, results by verdict,
  /// messages dropped.
  struct Tally {
    std::uint64_t samples = 0;
    std::uint64_t granted = 0;
    std::uint64_t accepted = 0;
    std::uint64_t duplicate = 0;
    std::uint64_t stale = 0;
    std::uint64_t mismatch = 0;
    std::uint64_t failed = 0;
    std::uint64_t malformed = 0;
  };
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  // Messages of workers (coordinator.cpp, scenes.cpp, results.cpp).
  void on(Time now, const PeerId& peer, msg::Hello& m);
  void on(Time now, const PeerId& peer, msg::Heartbeat& m);
  void on(Time now, const PeerId& peer, msg::NeedScene& m);
  void on(Time now, const PeerId& peer, msg::NeedChunk& m);
  void on(Time now, const PeerId& peer, msg::Result& m);
  void on(Time now, const PeerId& peer, msg::Failed& m);
  void on(Time now, const PeerId& peer, msg::Bye& m);
  // Messages of clients (clients.cpp).
  void on(Time now, const PeerId& peer, msg::Submit& m);
  void on(Time now, const PeerId& peer, msg::ListJobs& m);
  void on(Time now, const PeerId& peer, msg::ShowJob& m);
  void on(Time now, const PeerId& peer, msg::Fetch& m);
  void on(Time now, const PeerId& peer, msg::FetchJournal& m);
  void on(Time now, const PeerId& peer, msg::ListWorkers& m);
  void on(Time now, const PeerId& peer, msg::ShowFarm& m);
  // Those that change something (steering.cpp).
  void on(Time now, const PeerId& peer, msg::SteerJob& m);
  void on(Time now, const PeerId& peer, msg::SteerWorkers& m);
  template <typename Other>
  void on(Time now, const PeerId& peer, Other& m);  // not for a coordinator

  void refuse(Time now, const PeerId& peer, const Message& message);
  void send(const PeerId& peer, Message message);
  /// For people: from 1.
  [[nodiscard]] Epoch lease_number(Epoch epoch) const { return epoch - options_.first_epoch + 1; }
  void fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                    const std::string& message);
  [[nodiscard]] std::string refusal_of(const msg::Hello& hello) const;

  // Workers and leases (granting.cpp, losses.cpp).
  WorkerRecord* heard_from(Time now, const PeerId& peer);
  [[nodiscard]] unsigned pace() const;
  void welcome(WorkerRecord& worker);
  void note_progress(Time now, WorkerRecord& worker, const msg::Heartbeat& heartbeat);
  void lose_worker(Time now, const PeerId& peer, const std::string& why, bool failed);
  void judge_losses(Time now, const WorkerRecord& worker);
  void expire_leases(Time now);
  bool grant_leases(Time now);
  bool grant_one(Time now, WorkerRecord& worker, bool& room);
  bool grant_from(Time now, WorkerRecord& worker, Job& job, bool copy);
  [[nodiscard]] static bool may_trace(Time now, const WorkerRecord& worker, const Job& job);
  void send_grant(Time now, WorkerRecord& worker, Job& job, const Lease& lease);
  void note_storage(Time now);
  void release_workers(Time now);
  [[nodiscard]] double uptime() const;
  void keep_farm_notes();
  void restore_farm_notes();
  void note_damaged_rows(Job& job, const std::string& damage);

  // What clients want changed (steering.cpp).
  bool may_requeue(const PeerId& peer, std::uint64_t request, const Series& named);
  void steer(Job& job, const msg::SteerJob& m);
  void pause(Job& job, JobId named);
  void resume(Job& job);
  void cancel(Job& job);
  void requeue(Job& job);
  void prioritise(Job& job, std::uint32_t priority);
  void drain(const std::string& name, bool host);
  void readmit(const std::string& name, bool host);
  [[nodiscard]] std::string asker() const;
  [[nodiscard]] bool is_drained(const WorkerRecord& worker) const;
  void keep_worker_notes();
  void restore_worker_notes();

  // What may be kept, and by whom (housekeeping.cpp).
  void check_limits(const JobRecord& record) const;
  void keep_house(Time now);
  void note_usage(Store::Usage usage);
  void make_room_on_disk();
  void forget_job(JobId id, const std::string& why);
  void forget_all(const Series& listed, const std::string& why);

  // Scenes (scenes.cpp).
  [[nodiscard]] const SceneParcel* scene_at_work(const std::string& scene) const;
  void forget_scene(const std::string& scene);

  // Results (results.cpp).
  struct Merged;
  void take_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result,
                   const LeaseTable::Arrived& arrived);
  void note_merged(Job& job, const Merged& merged);
  void revoke_copies(const Job& job, Epoch epoch, const std::vector<WorkerId>& holders);
  void note_accepted(Job& job, const Merged& merged);
  void note_failure(Time now, Job& job, Failure failure);
  void note_success(Job& job, WorkerId worker);
  void hold_back(Time now);
  void end_pass_if_done(Job& job);

  // Checks, disputes, quarantines (disputes/disputes.cpp).
  void draw_check(Job& job, const Merged& merged);
  void place_check(Job& job, LeaseTable::Check check);
  void place_orphans(Job& job);
  [[nodiscard]] RefereeCase case_of(const Job& job, double length) const;
  bool check_by_referee(Job& job, const CellRange& range);
  void settle(Job& job, const Merged& merged);
  void open_dispute(Job& job, const Merged& merged);
  void look_after_checks();
  void take_referee_turn(Time now);
  void judge(RefereeDesk::Traced traced);
  struct Judged;
  void note_judged(Job& job, const Judged& judged);
  void hold_disputed_jobs(Time now);
  void quarantine(TracerKey machine, const std::string& reason);
  void retract(Job& job, const Conviction& conviction);
  void retract_later_convicted(Job& job);
  struct Retracted;
  void note_retracted(Job& job, const Retracted& retracted);
  void end_quarantines();
  void bar_as_due(WorkerRecord& worker);
  [[nodiscard]] nlohmann::json quarantined_elsewhere();
  [[nodiscard]] std::string worker_of(TracerKey machine) const;

  // Jobs (jobs.cpp).
  Job* job_of(JobId id);
  /// The job, if its work is still that of `generation`.
  Job* job_at_work(JobId id, std::uint64_t generation);
  Job* asked_for(const PeerId& peer, std::uint64_t request, JobId id);
  std::vector<Job*> asked_to_change(const PeerId& peer, std::uint64_t request, JobId id);
  std::vector<Job*> frames_of(JobId series);
  void join_series(JobRecord& record);
  [[nodiscard]] nlohmann::json summary_of(Time now, const Series& listed) const;
  void restore_jobs();
  void prepare(Time now, Job& job);
  struct Prepared;
  void trace_prepared(JobId id, std::uint64_t generation, const Prepared& prepared);
  void begin_tracing(Job& job, const Prepared& prepared);
  void restart_leases(Job& job, const WorkPlan& plan);
  void next_pass(Job& job);
  void finish_job(Job& job);
  void end_job(Job& job, JobState state, const std::string& reason);
  void close_job(Job& job, JobState state, const std::string& reason);
  void fail_job(Job& job, const std::string& reason);
  // Whom the failure of an errand concerns (errands.cpp).
  [[nodiscard]] Backroom::Guarded for_job(const Job& job, const std::string& doing);
  [[nodiscard]] Backroom::Guarded for_client(const PeerId& peer, std::uint64_t request,
                                             const std::string& doing);
  [[nodiscard]] Backroom::Guarded for_log(const std::string& doing);
  void keep(const Job& job);

  // Pictures and journals for clients (fetching.cpp).
  BulkLedger::Ticket admit_bulk(const PeerId& peer, std::uint64_t request, std::uint64_t bytes);
  void send_picture(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void send_kept_picture(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void note_picture_file(JobId id, const PictureFile& kept);
  [[nodiscard]] PictureJudge judge_of(const JobRecord& record) const {
    return record.settings.target_denoised && options_.judge_of ? options_.judge_of(record)
                                                                : PictureJudge{};
  }
  void note(Job& job, const std::string& what);
  /// Seconds, by the clock that the coordinator began with.
  [[nodiscard]] double since_1970(Time now) const { return wall_zero_ + to_seconds(now); }
  void make_room_for_job();
  bool make_room(std::uint64_t bytes);
  void list_open_jobs();
  void queue_open_jobs();
  [[nodiscard]] std::uint64_t memory_of(const Job& job) const;
  [[nodiscard]] std::uint64_t memory_in_use() const;
  [[nodiscard]] bool fits_beside_scenes(std::uint64_t needed, std::uint64_t scene) const;
  [[nodiscard]] std::string waits_for(const Job& job) const;
  struct Accepted;
  void accept_job(const PeerId& peer, std::uint64_t request, Accepted& accepted);

  const CoordinatorOptions options_;
  Store* const store_;  ///< the backroom's, once it is there
  std::shared_ptr<spdlog::logger> log_;
  LogBudget warnings_;
  LogBudget arrivals_;  ///< of workers, and departures
  WorkerRegistry workers_;
  SceneService scenes_;
  std::map<JobId, Job> jobs_;
  JobIndex index_;           ///< of jobs_
  std::set<JobId> at_work_;  ///< those with JobWork
  FairQueue queue_;          ///< of the open jobs
  Time queue_again_at_{};    ///< when what is left of them is to be looked at again
  double price_ = 1e-7;      ///< thread-seconds a sample, of the latest results
  Machines machines_;
  QuarantineLedger quarantines_;
  Convictions convictions_;
  CheckPolicy checks_;
  RefereeDesk desk_;
  bool any_held_ = false;                           ///< a job is, for a dispute
  std::set<std::pair<bool, std::string>> drained_;  ///< workers by name, or (true) by host
  std::map<std::string, std::uint64_t> disk_of_;    ///< of usage_, by user
  Store::Usage usage_;                              ///< of the store, some seconds ago
  Time next_housekeeping_{};
  RequestBudget requests_;
  BulkLedger bulk_;            ///< pictures and journals on their way to clients
  BulkLedger scenes_waiting_;  ///< of submits that are not acknowledged yet
  Backoff backoff_;
  std::map<std::string, JobId> submitting_;  ///< tokens whose job is being looked at, as listed
  /// Numbers of series, by user and token.
  std::map<std::pair<std::string, std::string>, JobId> series_;
  JobId next_job_ = 1;
  std::uint64_t next_generation_ = 1;
  Tally tally_;
  std::vector<Delivery> outbox_;
  Time grant_again_at_ = never;  ///< somebody may have leases again that it was denied
  bool grants_due_ = true;       ///< something has changed since everybody got what there was
  Sender sender_;                ///< of the message at hand
  PeerId granted_last_;          ///< the worker whose turn was the last
  std::string storage_;          ///< why nothing can be kept; empty: it can
  Time blocked_since_ = never;   ///< that nothing can be kept
  bool released_ = false;        ///< the workers were sent away because of that
  Time now_{};                   ///< of this turn
  Time began_ = never;           ///< the first tick
  double uptime_before_ = 0;     ///< seconds, of earlier lives
  double uptime_kept_ = 0;       ///< what the store has
  std::string progress_kept_;    ///< what the store has
  double wall_zero_ = 0;         ///< seconds since 1970 when `now` was 0; set by the first tick
  Backroom backroom_;            ///< last: its errands end before what they speak of
};

}  // namespace parray::coordinator
