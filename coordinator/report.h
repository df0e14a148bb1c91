#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/adaptive/error_estimate.h"
#include "common/image/picture_bytes.h"
#include "coordinator/job_picture.h"
#include "coordinator/store/job_record.h"

namespace parray {

/// What a report says of how the work went.
struct RenderFacts {
  double render_seconds = 0;            ///< from the first lease to the last result
  double trace_seconds = 0;             ///< of all workers, spent tracing, together
  double build_seconds = 0;             ///< the longest of any worker
  std::uint64_t accelerator_bytes = 0;  ///< the largest of any worker
  std::string isa;
  std::uint32_t threads = 0;
  std::size_t workers = 0;
};

/// A picture that is complete.
struct FinishedPicture {
  PictureParts picture;
  /// JSON; its fields are described in README.md, "The report": everything but what the client adds
  /// (seconds spent writing).
  std::string report;
};
FinishedPicture finish_picture(const JobPicture& picture, const JobRecord& record,
                               const RenderFacts& facts);

/// Figures as the map `error` of reports and job maps, null where unknown.
nlohmann::json error_to_json(const ErrorFigures& error);
/// Inverse; whatever is no such map, or has no such number, is unknown.
ErrorFigures error_from_json(const nlohmann::json& map);
/// Of the text of a report; empty: unknown.
ErrorFigures error_in(const std::string& report);

}  // namespace parray
