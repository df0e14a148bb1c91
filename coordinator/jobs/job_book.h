#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/jobs/queue_outlook.h"
#include "coordinator/jobs/series.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class DisputeDesk;
class WorkerDesk;

/// Leads every job through its life: submitted, prepared, traced in passes, finished, ended,
/// forgotten. Also applies the limits on jobs, memory and disk, and handles series.
class JobBook {
 public:
  JobBook(Farm& farm, DisputeDesk& disputes, WorkerDesk& worker_desk)
      : farm_(farm), disputes_(disputes), worker_desk_(worker_desk) {}

  /// Reads the records of the store. Unfinished pictures are read when their turn comes. Throws
  /// RunError if the store cannot be read.
  void restore_jobs();
  /// Accepts a submitted job, or answers why it is refused.
  void on(Time now, const PeerId& peer, msg::Submit& m);

  /// Lets the job thread allocate the memory for a job's picture and read the job's scene and
  /// results from the store.
  void prepare(Job& job);
  /// If all cells are merged and all checks are done: begins the next pass or finishes the picture.
  void end_pass_if_done(Job& job);
  /// Lets the job thread make picture and report. The job is done when the store has committed
  /// them.
  void finish_job(Job& job);
  /// Ends a job as failed.
  void fail_job(Job& job, const std::string& reason);
  /// Leases all cells of the first pass again, because a retraction has restarted the picture (see
  /// JobPicture::Retraction). `state`: the new state of the job's run.
  void restart_leases(Job& job, const RunState& state);
  /// Gives the job thread a task that works on the job. If it throws, the job fails. `doing`: what
  /// the task does, for the reason of the failure.
  void for_job(const Job& job, const std::string& doing, JobThread::Task task);

  /// Finds the frames of a series, in order. Empty: no series has this number.
  std::vector<Job*> frames_of(JobId series) const;
  /// Returns the job map of PROTOCOL.md of a job or a series.
  [[nodiscard]] nlohmann::json summary_of(Time now, const Series& listed);
  /// Returns the job map of a job, even if it is a frame of a series.
  [[nodiscard]] nlohmann::json summary_of(Time now, const Job& job);
  /// What an unfinished job waits for.
  struct Wait {
    std::string what;                   ///< a noun phrase, for people; empty: nothing
    JobId job = 0;                      ///< the job or series that goes first; 0: none
    std::uint32_t place = 0;            ///< in the queue, from 1; 0: not in it
    std::optional<double> starts_in{};  ///< estimated seconds until it begins
  };
  /// Returns what a job waits for. The estimates may be a second old.
  [[nodiscard]] Wait wait_of(const Job& job);
  /// Throws InputError if one more job like this would exceed a limit; NoRoom if waiting may help.
  void check_limits(const JobRecord& record) const;

  /// Changes a job as a client requested. Throws InputError if the job's state does not permit the
  /// change. `forget` changes nothing here: the caller then calls forget_all() or forget_job(). The
  /// caller calls list_open_jobs() afterwards.
  void steer(Job& job, const msg::SteerJob& m);
  /// Returns a name for the client of the current message, for a job's history.
  [[nodiscard]] std::string asker() const;
  /// Forgets an ended job. With the last frame of a series, or with a single job, also cancels and
  /// forgets its quick looks. `why`: the end of the log line "forgot job 7 'NAME' ...".
  void forget_job(JobId id, const std::string& why);
  /// Forgets a job, or all frames of a series, as forget_job() does.
  void forget_all(const Series& listed, const std::string& why);
  /// Requests a new queue and new grants, after jobs were added, ended or changed.
  void list_open_jobs();

  /// Returns the bytes of memory that a job needs while it is rendered.
  [[nodiscard]] std::uint64_t memory_of(const Job& job) const;
  /// Returns the bytes that count for CoordinatorOptions::memory now.
  [[nodiscard]] std::uint64_t memory_in_use() const;
  /// Returns whether `bytes` more fit into memory. Without a store, first drops data of ended jobs
  /// until they fit, if that suffices.
  bool make_room(std::uint64_t bytes);
  /// Returns the bytes on disk at the last count.
  [[nodiscard]] std::uint64_t disk_used() const { return usage_.total; }
  /// Does regular work every few seconds: ends quarantines, forgets old jobs, estimates errors and
  /// counts bytes on disk. Stores the uptime, the progress of jobs, and the time that users used.
  void keep_house(Time now);
  /// Stores what the next process cannot compute: the uptime and the progress of jobs.
  void keep_farm_notes();

 private:
  struct Accepted;
  struct Prepared;
  struct FinishedJob;
  void accept_job(const PeerId& peer, std::uint64_t request, Accepted& accepted);
  void join_series(JobRecord& record);
  void make_room_for_job();
  [[nodiscard]] bool fits_beside_scenes(std::uint64_t needed, std::uint64_t scene) const;
  /// Runs `step` on the job thread and then begins to trace the pass that the run has begun.
  /// `doing` names the task in messages. `purpose` completes the message about lack of memory.
  void prepare_pass(Job& job, const std::string& doing, const std::string& purpose,
                    std::function<void(JobRun&, Prepared&)> step);
  void trace_prepared(Job& job, Prepared& prepared);
  void begin_tracing(Job& job, const RunState& state, const std::vector<CellRange>& missing);
  void note_finished(Job& job, FinishedJob& finished);
  void end_job(Job& job, JobState state, const std::string& reason);
  void close_job(Job& job, JobState state, const std::string& reason);
  void pause(Job& job, JobId named);
  void resume(Job& job);
  void cancel(Job& job);
  void requeue(Job& job);
  void prioritise(Job& job, std::uint32_t priority);
  void estimate_errors();
  void note_end(Job& job, JobState state);
  void note_error(Job& job, std::uint64_t samples);
  void keep_unfinished(const Job& job, std::shared_ptr<JobRun> run);
  void drop_unfinished(std::uint64_t& in_use);
  void note_usage(Store::Usage usage);
  [[nodiscard]] Wait general_wait(const Job& job);
  [[nodiscard]] Wait series_wait(const Job& first_unfinished);
  [[nodiscard]] Wait queue_wait(const Job& job);
  struct Means {
    Time at = never;           ///< when they were counted
    std::uint64_t memory = 0;  ///< bytes in use
    bool room = false;         ///< a worker can take a lease
  };
  const Means& means();
  void renew_outlook();
  void warn_of_long_jobs();
  void make_room_on_disk();
  /// Calls forget_all(), unless the number is forgotten: a quick look is forgotten with its job.
  void forget_listed(JobId number, const std::string& why);
  void forget_previews(JobId of);
  void check_preview(const JobRecord& record) const;
  void forget_old_jobs();
  void restore_farm_notes();

  Farm& farm_;
  DisputeDesk& disputes_;
  WorkerDesk& worker_desk_;
  /// A submitted job that the job thread checks.
  struct Submitting {
    JobId listed = 0;  ///< JobRecord::listed_as()
    std::uint64_t pixels = 0;
  };
  /// By user and the name in the token.
  std::map<std::pair<std::string, std::string>, Submitting> submitting_;
  /// Numbers of series, by user and token.
  std::map<std::pair<std::string, std::string>, JobId> series_;
  JobId next_job_ = 1;
  std::uint64_t next_generation_ = 1;
  Store::Usage usage_;                            ///< of the store, at the last count
  std::map<std::string, std::uint64_t> disk_of_;  ///< of usage_, by user
  QueueOutlook outlook_;
  Time outlook_at_ = never;               ///< when outlook_ was made; never: it must be made
  std::uint64_t outlook_of_changes_ = 0;  ///< Farm::queue_changes when it was made
  Means means_;                           ///< of the current turn
  Time next_housekeeping_{};
  double uptime_kept_ = 0;     ///< seconds, as stored
  std::string progress_kept_;  ///< as stored
};

}  // namespace parray::coordinator
