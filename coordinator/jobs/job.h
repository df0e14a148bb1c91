#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "coordinator/jobs/job_failures.h"
#include "coordinator/jobs/job_run.h"
#include "coordinator/jobs/report.h"
#include "coordinator/leases/lease_table.h"
#include "coordinator/store/job_record.h"
#include "proto/payloads.h"

namespace parray::coordinator {

/// What the coordinator does with a job now.
enum class JobPhase : std::uint8_t {
  waiting,    ///< holds no memory for its picture
  preparing,  ///< the job thread is making its picture or its next pass
  tracing,    ///< has leases that can be granted or are granted
  finishing,  ///< the job thread is making the picture and the report
  ended
};

/// Data of a job that only exists while its picture is unfinished. Only the job thread may use
/// `*run`, and only the loop may use the rest.
struct JobWork : RunState {
  std::shared_ptr<JobRun> run;
  ScenePayload scene;
  std::optional<LeaseTable> leases;  ///< of the current pass; nothing before the first
  std::uint64_t generation = 0;      ///< unique number of this JobWork in this process
  std::uint32_t tasks = 0;           ///< tasks of the job thread that must end before the pass ends

  Time started = never;      ///< first grant
  Time clock_began = never;  ///< when the time limit began to count
  Time pass_began = never;
  Time pass_ended = never;           ///< all results were merged
  Time error_at = never;             ///< latest estimate of the error within a pass
  PartialError error_so_far;         ///< error while some pixels have fewer than two samples
  std::uint64_t samples_before = 0;  ///< samples at the first grant
  double taken_before = 0;           ///< JobCourse::taken at the first grant
  double pass_progress = 0;          ///< Job::progress() at the begin of the pass
  std::uint64_t pass_samples = 0;    ///< samples at the begin of the pass
  double deciding = 0;               ///< seconds that the latest decision on a pass took
  double price = 0;  ///< thread-seconds per sample of the latest results; 0: not known yet

  std::set<WorkerId> contributors;  ///< workers with an accepted result
  RenderFacts facts;
  JobFailures failures;
  bool held = false;  ///< it waits for the referee, as Job::pause_reason says
  /// Number of leases that were drawn for a check, but could not be checked, or only in part.
  std::uint64_t unchecked = 0;
};

/// A job in the coordinator's memory.
struct Job {
  JobRecord record;
  JobPhase phase = JobPhase::waiting;
  ScenePayload scene;      ///< only without a store
  Time submitted = never;  ///< when this process got it; never: an earlier process did
  /// When it was queued, in seconds since 1970. Negative: it has had a lease since then, or the
  /// time is not known.
  double queued_at = -1;
  Time served = never;   ///< latest lease with FairQueue::granted_by_turn(), or begin of waiting
  Time granted = never;  ///< latest lease, or begin of waiting
  Epoch next_epoch = 1;
  std::uint64_t spheres = 0;        ///< spheres and capsules; 0: not known yet
  std::unique_ptr<JobWork> work;    ///< null while the job waits and when it has ended
  std::string pause_reason;         ///< reason of a pause that ends without a client's action
  Time retry_at = never;            ///< when to finish it again after a full disk
  PicturePayload picture;           ///< of an ended job, only without a store
  std::string journal;              ///< of a done job, only without a store
  std::uint64_t picture_bytes = 0;  ///< of `picture` and `journal`
  std::string ended_by;             ///< of a done job, as in a job map; from its report
  bool stored = false;              ///< its results are in a store
  Time traced_since = never;        ///< JobCourse::taken lacks the time since then; never: none

  /// Returns the bytes of memory that the job keeps for later requests; 0 until it has ended.
  [[nodiscard]] std::uint64_t kept_bytes() const {
    return ended() ? picture_bytes + scene.size() : 0;
  }
  /// Estimates the samples that are not traced yet. The upper bound while samples_known() is false.
  [[nodiscard]] double samples_left(Time now) const;
  /// Estimates the seconds until the end. -1: unknown, or the job has ended.
  [[nodiscard]] double seconds_left(Time now) const;
  /// Returns the number of merged samples.
  [[nodiscard]] std::uint64_t samples() const;
  [[nodiscard]] double samples_a_pixel() const;
  /// Returns the seconds between its first lease and its end or now. Pauses by clients and times
  /// without a coordinator do not count.
  [[nodiscard]] double seconds_taken(Time now) const;
  /// Begins (`counts`) or stops counting seconds_taken().
  void count_time(Time now, bool counts);
  /// Returns whether its picture can be fetched now, complete or not.
  [[nodiscard]] bool has_picture() const;

  /// Returns whether the number of samples of the finished picture is known or estimated.
  [[nodiscard]] bool samples_known() const;
  /// Returns whether it has had a lease in this process.
  [[nodiscard]] bool begun() const { return work && work->started != never; }

  [[nodiscard]] bool ended() const { return phase == JobPhase::ended; }
  [[nodiscard]] bool tracing() const { return phase == JobPhase::tracing; }
  /// Returns the state that clients see: that of the record, or a temporary one.
  [[nodiscard]] std::string_view shown_state() const;
  /// Returns the mean speed since the first lease in this process, without pauses by clients. 0:
  /// not known yet, or the job has ended.
  [[nodiscard]] double samples_per_second(Time now) const;
  /// Returns the share of the work that is done, 0 to 1. With an error target it is an estimate
  /// from the current error, below 1 until the job is done. It decreases if results are removed
  /// and, in passes without a target, if a later pass needs more samples.
  [[nodiscard]] double progress(Time now) const;
  /// Returns the times that determine the size of the next pass under a time limit.
  [[nodiscard]] PassTimes times(Time now) const;
  /// Sets `ended_by` and the course's error, samples and progress from the report of a done job.
  /// Does nothing without a report.
  void read_report();

 private:
  [[nodiscard]] double share_left(Time now) const;
};

/// When a job or a series was submitted, started and ended, in seconds since 1970. Nothing:
/// unknown, or it has not happened.
struct JobTimes {
  std::optional<double> submitted;
  std::optional<double> started;   ///< its first lease
  std::optional<double> finished;  ///< only if it has ended
  /// Seconds from the start to the end or to now, without pauses. For a series: seconds from the
  /// first start of a frame to the latest time at which a frame was traced, pauses included.
  std::optional<double> taken;
};

JobTimes times_of(const Job& job, Time now);
/// Adds the times to a job map. Unknown times are null.
void add_times(nlohmann::json& summary, const JobTimes& times);

/// Returns the job map of PROTOCOL.md. `waits_for`: what an unfinished job waits for, as a noun
/// phrase for people; empty: nothing.
nlohmann::json job_summary(const Job& job, Time now, const std::string& waits_for);

}  // namespace parray::coordinator
