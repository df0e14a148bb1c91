#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "proto/job_head.h"

namespace parray::store {

using JobId = std::uint64_t;

/// Kept on disk by value: do not renumber.
enum class JobState : std::uint8_t { queued, running, paused, done, failed, cancelled };
std::string_view name_of(JobState state);

/// Whether a job in this state is yet to be rendered.
bool is_unfinished(JobState state);
/// Whether it may still be rendered, perhaps because somebody asks for it again, and so needs its
/// scene and its rows.
inline bool needs_scene(JobState state) { return state != JobState::done; }

/// Something that has happened to a job.
struct JobEvent {
  double at = 0;  ///< seconds since 1970
  std::string what;
};

/// What outlives a coordinator about a job.
struct JobRecord : JobHead {
  JobId id = 0;
  std::string token;
  std::string user;               ///< whose key has submitted it; empty: there were no keys
  std::uint32_t tile = 0;         ///< see WorkPlan; more than 1 only from parray-mpi
  std::string scene;              ///< digest
  std::uint64_t scene_bytes = 0;  ///< its size as it travels
  /// Samples of each pass that has begun; see common/image/passes.h.
  std::vector<std::uint64_t> passes{};
  JobState state = JobState::queued;
  std::string reason;  ///< of a failure
  std::string report;  ///< JSON, of a done job
  std::string flag;    ///< what was found wrong with results, and mended; empty: nothing
  /// Number of the latest finding whose machine's results were set back; see FaultFindings.
  std::uint64_t fault_findings = 0;
  double share = 1;     ///< of its user
  JobId series_id = 0;  ///< the series' number among those of jobs
  double ended = 0;  ///< uptime of the farm when it ended, in seconds; 0: it has not, or not known
  std::vector<JobEvent> events{};  ///< the first few and the latest

  /// The number under which people find it listed: that of its series, or its own.
  [[nodiscard]] JobId listed_as() const { return series_id != 0 ? series_id : id; }
  /// Adds to the events; of many, those in the middle are forgotten.
  void note(double at, std::string what);
};

/// For a job map.
nlohmann::json events_to_json(const std::vector<JobEvent>& events);

/// The record as JSON text, without its id. Text that is no UTF-8 has its bad bytes replaced.
std::string record_to_json(const JobRecord& job);

/// Inverse, for the job with this id. Throws RunError that names the job if `text` is no record.
JobRecord record_from_json(JobId id, std::string_view text);

}  // namespace parray::store
