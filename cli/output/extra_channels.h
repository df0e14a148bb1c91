#pragma once

#include <memory>
#include <string>

#include "cli/output/picture/picture.h"
#include "common/trace/integrator/path_tracer.h"
#include "worker/accelerator_cache.h"

namespace parray::output {

struct DenoisedSoFar;
struct OutputPaths;

/// Extra channels of a picture. Most are traced from the scene, by whoever writes the picture: no
/// farm knows of them. Without any of these, nothing of the scene is kept.
struct ExtraChannels {
  Aovs aovs;
  RenderSettings settings;             ///< resolved
  std::shared_ptr<const Scene> scene;  ///< null: nothing is traced
  int threads = 1;
  /// Wanted by what is done to the picture before it is looked at; traced as `aovs` are.
  Aovs for_finishing{};
  bool denoise = false;      ///< see cli/output/denoising.h; needs the scene, too
  bool transparent = false;  ///< the background is taken out; needs the scene, too
  /// Of whoever renders the picture in this process, if so: what it has built is used.
  std::shared_ptr<AcceleratorCache> accelerators = std::make_shared<AcceleratorCache>();
  /// What was denoised to tell the error of a picture under way. One thread at a time.
  std::shared_ptr<DenoisedSoFar> denoised{};
};

/// By the accelerator that is there, or one that is built. Needs the scene, of that identity.
std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id);

/// Whether the outputs of a job contain anything that this process traces from the scene.
bool needs_scene(const OutputPaths& outputs, const RenderSettings& settings);

/// The extra channels of a job. `scene` may be null unless needs_scene(). Settings with replicates
/// ask for denoising. `threads`: of this process.
ExtraChannels extra_channels(const OutputPaths& outputs, const RenderSettings& settings,
                             std::shared_ptr<const Scene> scene, int threads);

/// Whether the picture has to come with its statistics.
bool wants_statistics(const Aovs& aovs);

/// Adds channel `samples`, without which nobody could trace the picture again, where pixels have
/// different numbers of samples, unless it is there.
void add_sample_counts(Picture& picture);

/// Adds them to the picture: what is traced, and what its statistics say. Its report gets `aovs`,
/// the names of those that are written, if any, and `seconds.aovs`. Denoises it first, if asked,
/// and then takes its background out (cli/output/picture/transparency.h): the image is
/// premultiplied then, channel A its alpha, and the report gets `transparent`: `image_sha256`, that
/// of what the file shows, and `covered`, the mean of alpha; and `seconds.transparent`. Throws
/// Interrupted (see common/process/stop_signal.h).
void add_channels(Picture& picture, const ExtraChannels& extra);

}  // namespace parray::output
