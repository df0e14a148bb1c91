#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cli/output/picture/image_file.h"
#include "cli/output/picture/picture.h"
#include "common/adaptive/passes.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"
#include "worker/accelerator_cache.h"

namespace parray::output {

struct DenoisedSoFar;
struct OutputPaths;

/// The extra channels of a picture, and what else the client does with it. The client traces most
/// channels from the scene; the farm does not know them.
struct ExtraChannels {
  Aovs aovs;                           ///< channels that the file will contain
  Boxed<RenderSettings> settings;      ///< without automatic values
  std::shared_ptr<const Scene> scene;  ///< null unless needs_scene()
  int threads = 1;                     ///< threads that trace and denoise
  /// Channels that postprocessing needs. They are traced like `aovs`, but no file contains them.
  Aovs for_postprocessing{};
  bool denoise = false;  ///< denoise the picture (cli/output/denoise/denoise.h); needs the scene
  bool transparent = false;  ///< remove the background; needs the scene
  /// Accelerators for reuse: those of a farm in this process, if there is one.
  std::shared_ptr<AcceleratorCache> accelerators = std::make_shared<AcceleratorCache>();
  /// Results of denoising an unfinished picture to estimate its error. Used by one thread at a
  /// time.
  std::shared_ptr<DenoisedSoFar> denoised{};
};

/// Returns a tracer of extra.scene, with an accelerator of extra.accelerators or a new one. Needs
/// the scene. `scene_id`: SHA-256 of the scene.
std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id);

/// Returns whether the outputs of a job need the scene in this process: for traced channels, for
/// denoising, or to remove the background.
bool needs_scene(const OutputPaths& outputs, const RenderSettings& settings);

/// Returns the extra channels of a job. `scene` may be null unless needs_scene(). Settings with
/// replicates, the input of the denoiser, mean that the picture will be denoised. `threads`: number
/// of threads in this process.
ExtraChannels extra_channels(const OutputPaths& outputs, const RenderSettings& settings,
                             std::shared_ptr<const Scene> scene, int threads);
/// Returns the extra channels of a job whose scene this process does not have. The caller must know
/// that the outputs do not need it.
ExtraChannels extra_channels(const OutputPaths& outputs);

/// Adds channel `samples` if pixels have different numbers of samples and the channel is missing.
/// Without it, the picture could not be traced again.
void add_sample_counts(Picture& picture);

/// Prefix of the EXR channels that contain the picture before denoising.
inline constexpr const char* raw_channel = "raw.";

/// Returns the picture before denoising from the channels of an EXR file. Returns nothing if the
/// channels are missing.
std::optional<Image> raw_image(const ImageFile& file);

/// Returns a function that denoises an unfinished picture and returns the error of the result. The
/// function keeps the result in extra.denoised for add_channels(). `extra` must outlive the
/// function. `scene_id`: SHA-256 of extra.scene.
PictureJudge denoised_judge(ExtraChannels& extra, const std::string& scene_id);

/// First denoises the picture if requested. The channels raw.R, raw.G, raw.B keep the picture
/// before denoising. The report gets `denoised` (`rmse`, `low`, `high` and `image_sha256` of the
/// denoised picture) and `seconds.denoise`. `image_sha256` and `error` still describe the picture
/// before denoising. If a pixel has fewer than 2 samples, prints a warning instead. If
/// extra.denoised has the result for the same number of samples, moves it from there instead of
/// denoising again.
///
/// Then removes the background if requested (cli/output/picture/transparency.h). After removal the
/// image is premultiplied and channel A is alpha. The report then gets `seconds.transparent` and
/// `transparent`: `image_sha256` of the premultiplied picture with alpha, and `covered`, the mean
/// of alpha over all pixels. Last, adds the channels to the picture: traced ones and those from
/// statistics. If there are any, the report gets `aovs`, the names of the written channels,
/// `channel_samples` and `seconds.aovs`. Throws Interrupted (common/process/stop_signal.h), and
/// RunError if the coordinator has not sent what denoising or the removal needs.
void add_channels(Picture& picture, const ExtraChannels& extra);

}  // namespace parray::output
