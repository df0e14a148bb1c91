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

/// What a report says about the render itself.
struct RenderFacts {
  /// From the first lease of this process until the picture was complete.
  double render_seconds = 0;
  std::uint64_t samples_before = 0;     ///< samples that the picture had before that lease
  double deciding_seconds = 0;          ///< part of render_seconds in which passes were planned
  double trace_seconds = 0;             ///< sum of the tracing times of all workers
  double build_seconds = 0;             ///< the longest of any worker, for its accelerator
  std::uint64_t accelerator_bytes = 0;  ///< the largest of any worker
  std::string isa;                      ///< instruction set of the latest result, or of rank 0
  std::uint32_t threads = 0;            ///< sum over all that `workers` counts
  std::size_t workers = 0;              ///< workers with an accepted result, or ranks
};

/// Estimates the times of the work that follows the last sample, after `elapsed` seconds and
/// `samples` samples. The estimate uses the number of pixels and the cost of one pixel on a core of
/// about 2 GHz, with a margin.
PassTimes ending_times(const RenderSettings& settings, std::uint64_t samples, double elapsed);

/// The floats of a picture, finished or not. Pixels without a sample are filled from others.
struct ShownImage {
  Image image;
  Fill fill;  ///< how many pixels were filled
};
/// Makes a picture's floats from its current sums.
ShownImage shown_image(const JobPicture& picture);

/// Makes the picture from the current sums. Pixels without a sample get the colours of others. All
/// half-widths are infinite while any pixel has fewer than two samples. `statistics`: also the
/// numbers of samples and the half-widths, which take longer.
PictureParts parts_so_far(const JobPicture& picture, bool statistics);

/// A picture that is complete.
struct FinishedPicture {
  PictureParts picture;
  /// JSON with the fields of cli/REFERENCE.md, "The report", except the seconds spent writing. The
  /// client adds those.
  std::string report;
};
/// Returns which parts of a picture with these settings the coordinator keeps.
PictureDetail kept_detail(const WorkSettings& settings);

/// Makes picture and report. All samples must be merged.
FinishedPicture finish_picture(const JobPicture& picture, const JobRecord& record,
                               const RenderFacts& facts);

/// Reads the figures from the text of a report. Empty text: all are unknown.
ErrorFigures error_in(const std::string& report);

}  // namespace parray::coordinator
