#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/output/picture/image_file.h"
#include "cli/output/picture/picture.h"
#include "common/scene/settings.h"

/// Everything that decides the bits of a picture, kept inside its file: whoever has the scene can
/// make the same bits again, all of them or those of single pixels.
namespace parray::output {

struct Recipe {
  std::string image_sha256;   ///< of the picture's floats, as in the report
  std::string pixels_sha256;  ///< of png_bytes() of what the file shows; empty: an EXR file
  std::string finished;       ///< what was done to the PNG file after tracing; empty: nothing
  /// Of the floats of the denoised picture; empty: it is not denoised.
  std::string denoised_sha256;
  /// transparent_sha256() of what the file shows, the picture or the denoised one without its
  /// background; empty: it is there.
  std::string transparent_sha256;
  std::string scene_sha256;
  std::uint64_t trace_version = 0;
  std::string version;  ///< of ParRay
  /// What decides the bits of a sample, and how many samples there are: `samples_per_pixel`, or,
  /// where pixels have different numbers, the `passes` that lead to these.
  RenderSettings settings;
  std::uint64_t samples = 0;          ///< of all pixels together
  bool equal_samples = false;         ///< every pixel has settings.samples_per_pixel
  std::uint32_t channel_samples = 0;  ///< of each pixel in its extra channels; 0: there are none
};

/// By its report: pixels have different numbers of samples.
bool samples_differ(const nlohmann::json& report);

/// Of a PNG file: what was done to the picture after it was traced, such as labels.
inline constexpr const char* finished_key = "parray:finished";

/// The recipe, and what else an image file says of a picture: of its report what decides the bits,
/// what came of it, and the error.
ImageMetadata recipe_metadata(const Picture& picture);
/// The same for a PNG file, which shows `shown`, with `alpha` if that is a channel: with the hash
/// of its pixels.
ImageMetadata recipe_metadata(const Picture& picture, const Image& shown,
                              const Channels& alpha = {});

/// The recipe that a file holds; `file` names it in errors. Throws InputError: there is none, or a
/// value that is missing or out of its range.
Recipe recipe_in(const ImageMetadata& metadata, const std::string& file);

/// Throws InputError unless a scene of identity `scene_sha256`, read from `scene`, and the tracer
/// of this program make the picture that has the recipe, `picture`.
void check_recipe(const Recipe& recipe, const std::string& picture, const std::string& scene_sha256,
                  const std::string& scene);

}  // namespace parray::output
