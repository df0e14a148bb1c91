#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/output/denoise/denoise.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"
#include "common/adaptive/passes.h"

namespace parray::output {

/// Prefix of the channels in which an EXR file keeps the picture as its samples make it, beside
/// the denoised one.
inline constexpr const char* raw_channel = "raw.";

/// The picture as its samples make it, from the channels of an EXR file that holds a denoised one;
/// none if they are not there.
std::optional<Image> raw_image(const ImageFile& file);

/// What is known of a picture from denoising it before.
struct DenoisedSoFar {
  std::uint64_t samples = 0;  ///< of all pixels together, when it was denoised
  std::uint32_t least = 0;    ///< of a pixel, when the features were traced
  Features features;
  Denoised picture;
};

/// Says how far the denoised picture is from the truth, and keeps what it did in extra.denoised, so
/// that denoise_picture() need not do it again. Refers to `extra`, whose scene has that identity.
PictureJudge denoised_judge(ExtraChannels& extra, const std::string& scene_id);

/// Denoises a picture that has come with its replicates (cli/output/denoise/denoise.h): its image
/// is the denoised one then, and the raw one is in channels raw.R, raw.G, raw.B. Its report gets
/// `denoised`: `rmse`, `low`, `high` and `image_sha256` of the denoised picture, and
/// `seconds.denoise`; `image_sha256` and `error` stay those of the raw picture. A picture in which
/// a pixel has less than 2 samples stays as it is, and stderr says so. Throws Interrupted.
void denoise_picture(Picture& picture, const PathTracer& tracer, const ExtraChannels& extra);

}  // namespace parray::output
