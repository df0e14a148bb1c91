#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "cli/measure/plan/effort.h"
#include "cli/measure/plan/error_model.h"
#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"

namespace parray::plan {

/// The task of a probe and its time.
struct ProbeRequest {
  const Scene* scene = nullptr;
  Boxed<RenderSettings> settings;  ///< no value is `automatic`; sampler and limits are ignored
  /// The plan chooses among these, one or two. If there are two, the probe measures only the speed
  /// of the first.
  std::vector<Sampler> samplers;
  int threads = 1;
  double seconds = 3;       ///< about the longest time of the probe, after building the accelerator
  double error = 0;         ///< target error; 0: none
  double goal_seconds = 0;  ///< time of the planned render; 0: the time that `error` takes
  std::filesystem::path image;  ///< the picture file of the render: its format matters
};

/// Error laws and times of one sampler.
struct SamplerProbe {
  Sampler sampler = Sampler::independent;
  ErrorModel uniform;      ///< every pixel has the same number of samples
  ErrorModel adaptive;     ///< adaptive passes
  Effort uniform_sample;   ///< time of one sample of one pixel, with the same number in every pixel
  Effort adaptive_sample;  ///< time of one sample of one pixel that adaptive passes place
};

/// Results of a few seconds of tracing a scene. Times and errors are those of the whole picture.
struct Probe {
  std::vector<SamplerProbe> samplers;  ///< in the order of the request
  /// Time of the steps that every picture of the scene needs once.
  Effort fixed;
  /// Time to collect the results of a pass, for any number of samples.
  Effort collect;
  Effort pass;                  ///< time of the decision before each adaptive pass
  Effort overheads;             ///< time of the steps after the last sample
  UpperBound stated_uniform;    ///< of a picture with the same number of samples in every pixel
  UpperBound stated_adaptive;   ///< of a picture after adaptive passes
  bool placing_pays = true;     ///< whether adaptive passes place samples by noise
  double largest_radiance = 0;  ///< upper bound of a sample's radiance
  double timing_doubt = 0;      ///< relative standard error of the times, from their variation
  std::uint64_t pixels = 0;     ///< pixels of the part whose errors were measured
  std::uint64_t samples = 0;    ///< all traced samples
  double seconds = 0;           ///< duration of the probe, with building the accelerator
};

/// Traces parts of the picture as the render would. Returns nothing if `stop` becomes true. Throws
/// RunError if the trial file (measure_overheads()) cannot be written.
std::optional<Probe> probe(const ProbeRequest& request, const std::atomic<bool>& stop);

}  // namespace parray::plan
