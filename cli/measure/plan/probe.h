#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "cli/measure/plan/effort.h"
#include "cli/measure/plan/error_model.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"

namespace parray::plan {

/// What to find out, and how long that may take.
struct ProbeRequest {
  const Scene* scene = nullptr;
  RenderSettings settings;        ///< resolved; sampler and limits do not matter
  std::vector<Sampler> samplers;  ///< candidates, at least one; the last gets the longest look
  int threads = 1;
  double seconds = 3;           ///< by the clock, about; building comes on top
  double error = 0;             ///< that is wanted; 0: none in particular
  double goal_seconds = 0;      ///< time that the render will take; 0: that of `error`
  std::filesystem::path image;  ///< the file that will be written: its kind matters
};

/// How a sampler's pictures of the scene get along.
struct SamplerProbe {
  Sampler sampler = Sampler::independent;
  ErrorModel uniform;      ///< equal counts
  ErrorModel adaptive;     ///< adaptive passes
  Effort uniform_sample;   ///< of one sample
  Effort adaptive_sample;  ///< of one where adaptive passes put them
};

/// What a few seconds of tracing tell of rendering a scene.
struct Probe {
  std::vector<SamplerProbe> samplers;  ///< in the order of the request
  Effort fixed;                        ///< of all that is done once, for any picture of the scene
  Effort collect;                      ///< of each pass that is traced, whatever its samples
  Effort pass;                         ///< of deciding on each that is adaptive, likewise
  Effort finish;                       ///< of all that is done once the picture is traced
  UpperBound stated_uniform;
  UpperBound stated_adaptive;
  bool placing_pays = true;     ///< adaptive passes place samples by noise
  double largest_radiance = 0;  ///< that a sample of the scene can have
  double timing_doubt = 0;      ///< standard error of times / times, from how they varied
  std::uint64_t pixels = 0;     ///< that were traced
  std::uint64_t samples = 0;    ///< likewise
  double seconds = 0;           ///< that it took
};

/// Traces parts of the picture, as its render would. None if `stop` was set meanwhile. Throws
/// RunError.
std::optional<Probe> probe(const ProbeRequest& request, const std::atomic<bool>& stop);

}  // namespace parray::plan
