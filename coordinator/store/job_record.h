#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/settings.h"

namespace parray {

using JobId = std::uint64_t;

/// Kept on disk by value: do not renumber.
enum class JobState : std::uint8_t { queued, running, paused, done, failed, cancelled };
std::string_view name_of(JobState state);

/// Whether a job in this state may still be rendered, and so needs its scene and its rows.
bool is_unfinished(JobState state);

/// What outlives a coordinator about a job.
struct JobRecord {
  JobId id = 0;
  std::string token;
  std::string name;
  std::string user;  ///< whose key has submitted it; empty: there were no keys
  std::uint32_t priority = 50;
  RenderSettings settings;
  std::uint32_t tile = 0;  ///< see WorkPlan; more than 1 only from parray-mpi
  std::string precision_reason;
  std::uint64_t duplicates_removed = 0;
  double load_seconds = 0;
  std::string scene;              ///< digest
  std::uint64_t scene_bytes = 0;  ///< its size as it travels
  /// Samples of each pass that has begun; see common/image/passes.h.
  std::vector<std::uint64_t> passes{};
  JobState state = JobState::queued;
  std::string reason;  ///< of a failure
  std::string report;  ///< JSON, of a done job
  std::string flag;    ///< what was found wrong with results, and mended; empty: nothing
};

/// The record as JSON text, without its id. Text that is no UTF-8 has its bad bytes replaced.
std::string record_to_json(const JobRecord& job);

/// Inverse, for the job with this id. Throws RunError that names the job if `text` is no record.
JobRecord record_from_json(JobId id, std::string_view text);

}  // namespace parray
