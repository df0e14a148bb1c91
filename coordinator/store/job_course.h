#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace parray::store {

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

  static constexpr std::size_t most_points = 200;
  /// Adds a point. Removes points with as many samples or more, because their picture was changed.
  /// If there are too many points, removes every second one.
  void add(const ErrorPoint& point);

  friend bool operator==(const JobCourse&, const JobCourse&) = default;
};

/// Returns the curve as the list `passes` of a job map.
nlohmann::json curve_to_json(const std::vector<ErrorPoint>& curve);
nlohmann::json course_to_json(const JobCourse& course);
/// Reads the output of course_to_json(). Missing members are unknown. Throws RunError if a member
/// is out of range, or nlohmann::json::exception if it has the wrong type.
JobCourse course_from_json(const nlohmann::json& map);

}  // namespace parray::store
