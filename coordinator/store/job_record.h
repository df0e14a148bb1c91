#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/adaptive/error_figures.h"
#include "proto/job_head.h"

namespace parray::store {

using JobId = std::uint64_t;

/// The state of a job. Stored by value: do not renumber.
enum class JobState : std::uint8_t { queued, running, paused, done, failed, cancelled };
std::string_view name_of(JobState state);

/// Returns whether a job in this state has not ended.
bool is_unfinished(JobState state);
/// Returns whether a job in this state needs its scene. Failed and cancelled jobs do, because
/// `requeue` can continue them; a done job does if `keeps_scene` (JobHead::keeps_scene()).
inline bool needs_scene(JobState state, bool keeps_scene) {
  return state != JobState::done || keeps_scene;
}

/// An event in the life of a job.
struct JobEvent {
  double at = 0;  ///< seconds since 1970
  std::string what;
};

/// A point of the curve of a job's error.
struct ErrorPoint {
  double seconds = 0;  ///< time that the job had taken
  double samples = 0;  ///< mean per pixel
  double rmse = -1;    ///< negative: unknown

  friend bool operator==(const ErrorPoint&, const ErrorPoint&) = default;
};

/// The times of a job, and what it has of its picture. Lists of jobs show them, so they must not
/// depend on its log or its picture.
struct JobCourse {
  double submitted = 0;  ///< seconds since 1970; 0: unknown, as in the next two
  double started = 0;    ///< first lease
  double finished = 0;   ///< latest end, also of a job that was queued again
  /// Seconds from the first lease to the end, without pauses. While the job is traced, this does
  /// not include the time since the first lease or the latest resume: see Job::traced_since.
  double taken = 0;
  double progress = 0;            ///< 0 to 1, at the end of the job or of the latest coordinator
  std::uint64_t samples = 0;      ///< merged samples at that time
  std::vector<ErrorPoint> curve;  ///< at most most_points, with rising samples
  adaptive::ErrorFigures error;   ///< the latest estimate; for a done job, from its report

  static constexpr std::size_t most_points = 200;
  /// Adds a point. Removes points with as many samples or more, because their picture was changed.
  /// If there are too many points, removes every second one.
  void add(const ErrorPoint& point);
  /// Forgets what it says of the picture, because the picture and its samples are lost.
  void forget_picture();

  friend bool operator==(const JobCourse&, const JobCourse&) = default;
};

/// Everything that the state stores about a job except scene, results and picture.
struct JobRecord : JobHead {
  JobId id = 0;
  std::string token;              ///< of its submit, see name_in_token()
  std::string user;               ///< name of the submitting key; without keys, as the client says
  std::uint32_t tile = 0;         ///< see WorkPlan; more than 1 only in jobs of parray-mpi
  std::string scene;              ///< digest
  std::uint64_t scene_bytes = 0;  ///< size of the encoded scene
  /// Samples of each pass that has begun; see common/adaptive/passes.h.
  std::vector<std::uint64_t> passes{};
  JobState state = JobState::queued;
  std::string reason;     ///< why the job failed, was cancelled or is paused
  std::string report;     ///< JSON, only of a done job
  std::string warning{};  ///< for people, if its forecast exceeded a day; otherwise empty
  std::string flag;       ///< what is or was wrong with its results or files; empty: nothing
  /// Number of the latest finding that the job has taken into account; see FaultFindings.
  std::uint64_t fault_findings = 0;
  double share = 1;     ///< the user's share of the farm, relative to other users' shares
  JobId series_id = 0;  ///< number of the series, unique among jobs; 0: a single job
  double ended = 0;     ///< uptime of the farm at its latest end in s; 0: never ended, or unknown
  std::vector<JobEvent> events{};  ///< the first 16 and the latest 48
  JobCourse course{};

  /// Returns the number under which lists show the job: that of its series, or its own.
  [[nodiscard]] JobId listed_as() const { return series_id != 0 ? series_id : id; }
  /// Adds an event. Removes the oldest event after the first 16 if there are more than 64.
  void note(double at, std::string what);
};

/// Return the lists `events` and `passes` of a job map.
nlohmann::json events_to_json(const std::vector<JobEvent>& events);
nlohmann::json curve_to_json(const std::vector<ErrorPoint>& curve);

/// Returns the map `error` of reports and job maps. Unknown figures are null.
nlohmann::json error_to_json(const adaptive::ErrorFigures& error);
/// Reads such a map. Missing and invalid figures are unknown.
adaptive::ErrorFigures error_from_json(const nlohmann::json& map);

/// Returns the record as JSON text, without its id. Replaces bytes that are not valid UTF-8.
std::string record_to_json(const JobRecord& job);
/// Reads the record of the job `id`. Throws RunError that names the job if `text` is no record.
JobRecord record_from_json(JobId id, std::string_view text);

}  // namespace parray::store
