#pragma once

#include <memory>
#include <string>

#include "cli/output/picture/picture.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"
#include "worker/accelerator_cache.h"

namespace parray::output {

struct DenoisedSoFar;
struct OutputPaths;

/// Extra channels of a picture. The client traces most of them from the scene; the farm does not
/// know them. Without such channels `scene` is null.
struct ExtraChannels {
  Aovs aovs;
  Boxed<RenderSettings> settings;      ///< resolved
  std::shared_ptr<const Scene> scene;  ///< null: no channel is traced
  int threads = 1;
  /// Channels that postprocessing needs; traced like `aovs`.
  Aovs for_finishing{};
  bool denoise = false;      ///< see cli/output/denoising.h; needs the scene
  bool transparent = false;  ///< remove the background; needs the scene
  /// Accelerators that are reused: those of a farm in this process, if there is one.
  std::shared_ptr<AcceleratorCache> accelerators = std::make_shared<AcceleratorCache>();
  /// Results of denoising an unfinished picture to estimate its error. One thread at a time.
  std::shared_ptr<DenoisedSoFar> denoised{};
};

/// Returns a tracer with the existing accelerator or a new one. Needs the scene, which has that
/// identity.
std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id);

/// Whether the outputs of a job contain anything that this process traces from the scene.
bool needs_scene(const OutputPaths& outputs, const RenderSettings& settings);

/// The extra channels of a job. `scene` may be null unless needs_scene(). Settings with replicates
/// ask for denoising. `threads`: of this process.
ExtraChannels extra_channels(const OutputPaths& outputs, const RenderSettings& settings,
                             std::shared_ptr<const Scene> scene, int threads);
/// The extra channels of a job whose scene this process does not have.
ExtraChannels extra_channels(const OutputPaths& outputs);

/// Whether the channels need the statistics of the picture.
bool wants_statistics(const Aovs& aovs);

/// Adds channel `samples` if pixels have different numbers of samples and the channel is absent.
/// Without the channel the picture could not be traced again.
void add_sample_counts(Picture& picture);

/// Adds the channels to the picture: those that are traced, and those from statistics. The report
/// gets `aovs`, the names of the written ones, and `seconds.aovs`. Before that, denoises the
/// picture if requested and removes the background if requested
/// (cli/output/picture/transparency.h). Then the image is premultiplied, channel A is alpha, and
/// the report gets `seconds.transparent` and `transparent`: `image_sha256` of the file's picture,
/// and `covered`, the mean of alpha. Throws Interrupted (common/process/stop_signal.h).
void add_channels(Picture& picture, const ExtraChannels& extra);

}  // namespace parray::output
