#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

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

/// What is left to do for a picture of these settings when all samples are in, as PassTimes has it:
/// `elapsed` seconds have gone, and it has `samples`. From the number of pixels, at what one costs
/// on a core of about 2 GHz, with a margin.
PassTimes ending_times(const RenderSettings& settings, std::uint64_t samples, double elapsed);

/// A picture that is complete.
struct FinishedPicture {
  PictureParts picture;
  /// JSON; its fields are described in README.md, "The report": everything but what the client adds
  /// (seconds spent writing).
  std::string report;
};
/// What is kept of the picture of a job with these settings.
PictureDetail kept_detail(const WorkSettings& settings);

FinishedPicture finish_picture(const JobPicture& picture, const JobRecord& record,
                               const RenderFacts& facts);

}  // namespace parray
