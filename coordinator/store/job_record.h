#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/job_course.h"
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

/// Everything that the state stores about a job except scene, results and picture.
struct JobRecord : JobHead {
  JobId id = 0;
  std::string token;              ///< of its submit, see submit_token.h
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

/// Returns the list `events` of a job map.
nlohmann::json events_to_json(const std::vector<JobEvent>& events);

/// Returns the record as JSON text, without its id. Replaces bytes that are not valid UTF-8.
std::string record_to_json(const JobRecord& job);

/// Reads the record of the job `id`. Throws RunError that names the job if `text` is no record.
JobRecord record_from_json(JobId id, std::string_view text);

}  // namespace parray::store
