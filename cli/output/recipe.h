#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/output/picture/image_file.h"
#include "cli/output/picture/picture.h"
#include "common/scene/settings_fwd.h"

/// All values that determine the bits of a picture, stored in its file. With the scene, ParRay can
/// reproduce the whole picture or single pixels.
namespace parray::output {

struct Recipe {
  /// Hash of the floats of the picture before denoising and with its background, as in the report.
  std::string image_sha256;
  std::string pixels_sha256;  ///< hash of png_bytes() of the file's picture; empty: an EXR file
  std::string finished;       ///< names_of() postprocessing of the file; empty: none, as in EXR
  /// Hash of the floats of the denoised picture. Empty: not denoised.
  std::string denoised_sha256;
  /// transparent_sha256() of the picture, denoised or not, before postprocessing. Empty: it has its
  /// background. A file whose finishing begins with a background step has this hash, but no alpha.
  std::string transparent_sha256;
  std::string scene_sha256;
  std::uint64_t trace_version = 0;
  std::string version;  ///< of ParRay
  /// Settings that decide the bits of a sample, and the number of samples: `samples_per_pixel`, or
  /// `passes` if pixels have different numbers.
  Boxed<RenderSettings> settings;
  std::uint64_t samples = 0;   ///< total number of samples
  bool equal_samples = false;  ///< true: every pixel has settings.samples_per_pixel
  std::uint32_t channel_samples =
      0;  ///< samples per pixel of the extra channels; 0: no such channels
};

/// Returns whether pixels have different numbers of samples, according to the report.
bool samples_differ(const nlohmann::json& report);

/// Key of the postprocessing steps in a file other than EXR.
inline constexpr const char* finished_key = "parray:finished";
/// Name of the step that puts a transparent picture on a background, before all others.
inline constexpr const char* background_step = "background";

/// Returns the metadata of a picture: its recipe, its hashes and its error, from the report.
ImageMetadata recipe_metadata(const Picture& picture);
/// Does the same for a file other than EXR that shows `shown`, with `alpha` if there is such a
/// channel. Includes the hash of its pixels.
ImageMetadata recipe_metadata(const Picture& picture, const Image& shown,
                              const Channels& alpha = {});

/// Reads the recipe of a file. `file` is its name for messages. Throws InputError if the picture is
/// unfinished, the recipe is missing, or a value is missing or out of range.
Recipe recipe_in(const ImageMetadata& metadata, const std::string& file);

/// Throws InputError unless the picture has this program's trace_version and was made from the
/// scene with the SHA-256 `scene_sha256`. `picture` and `scene` are names for messages.
void check_recipe(const Recipe& recipe, const std::string& picture, const std::string& scene_sha256,
                  const std::string& scene);

}  // namespace parray::output
