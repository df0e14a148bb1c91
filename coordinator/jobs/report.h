#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/adaptive/error_estimate.h"
#include "common/image/image.h"
#include "common/image/lattice.h"
#include "common/image/picture_bytes.h"
#include "common/scene/settings_fwd.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/job_record.h"

namespace parray::coordinator {

/// What a report says of how the work went.
struct RenderFacts {
  double render_seconds = 0;            ///< from the first lease to the last result
  double deciding_seconds = 0;          ///< of those, deciding on passes; nobody traces meanwhile
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

/// The image as far as it has been traced; pixels without a sample are filled.
struct ShownImage {
  Image image;
  Fill fill;
};
ShownImage shown_image(const JobPicture& picture);

/// A picture that is complete.
struct FinishedPicture {
  PictureParts picture;
  /// JSON; its fields are described in cli/REFERENCE.md, "The report": everything but what the
  /// client adds (seconds spent writing).
  std::string report;
};
/// What is kept of the picture of a job with these settings.
PictureDetail kept_detail(const WorkSettings& settings);

FinishedPicture finish_picture(const JobPicture& picture, const JobRecord& record,
                               const RenderFacts& facts);

/// Figures as the map `error` of reports and job maps, null where unknown.
nlohmann::json error_to_json(const ErrorFigures& error);
/// Inverse; whatever is no such map, or has no such number, is unknown.
ErrorFigures error_from_json(const nlohmann::json& map);
/// Of the text of a report; empty: unknown.
ErrorFigures error_in(const std::string& report);

}  // namespace parray::coordinator
