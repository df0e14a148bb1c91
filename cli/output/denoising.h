#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/output/denoise/denoise.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"
#include "common/adaptive/passes.h"

namespace parray::output {

/// Prefix of the EXR channels that contain the picture before denoising.
inline constexpr const char* raw_channel = "raw.";

/// Returns the picture before denoising from the channels of an EXR file. Returns nothing if the
/// channels are missing.
std::optional<Image> raw_image(const ImageFile& file);

/// The state of an earlier denoising of the same picture.
struct DenoisedSoFar {
  std::uint64_t samples = 0;  ///< number of samples in total at that time
  std::uint32_t least = 0;    ///< argument `samples` of trace_features() for `features`
  Features features;
  Denoised picture;
};

/// Returns a function that denoises an unfinished picture and returns the error of the result. The
/// function keeps the result in extra.denoised for denoise_picture(). `extra` must outlive the
/// function. `scene_id`: SHA-256 of extra.scene.
PictureJudge denoised_judge(ExtraChannels& extra, const std::string& scene_id);

/// Denoises a picture with replicates (cli/output/denoise/denoise.h). The image becomes the
/// denoised picture. The channels raw.R, raw.G, raw.B keep the picture before denoising. The report
/// gets `denoised` (`rmse`, `low`, `high` and `image_sha256` of the denoised picture) and
/// `seconds.denoise`. `image_sha256` and `error` still describe the picture before denoising. If a
/// pixel has fewer than 2 samples, prints a warning and changes nothing. If extra.denoised has the
/// result for the same number of samples, moves it from there instead of denoising again. `tracer`:
/// tracer_of(extra). Throws Interrupted, and RunError if the picture has no replicates.
void denoise_picture(Picture& picture, const PathTracer& tracer, const ExtraChannels& extra);

}  // namespace parray::output
