#pragma once

#include <optional>
#include <string>

#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::plan {

/// Measurements of some pixels of a picture.
struct DenoisingProbe {
  double samples = 0;   ///< per pixel
  double raw = 0;       ///< RMSE before denoising
  double denoised = 0;  ///< RMSE after it
  /// Samples per pixel that could be traced in the time of denoising.
  double samples_instead = 0;
};

/// Two pictures that take the same time, with and without denoising. Errors are RMSE in linear
/// radiance.
struct DenoisingWorth {
  double samples = 0;       ///< per pixel of the denoised picture
  double denoised = 0;      ///< error of the denoised picture
  double more_samples = 0;  ///< per pixel of the picture without denoising
  double undenoised = 0;    ///< error of the picture without denoising

  /// Returns whether denoising pays. Ignores a small disadvantage, because predictions of errors
  /// have an uncertainty of about 15 %.
  [[nodiscard]] bool pays() const { return denoised <= 1.15 * undenoised; }
};

/// Predicts the errors of both pictures for the number of samples or the target of `settings`.
/// `limit_samples`: samples per pixel that a time limit allows without denoising; 0: no limit.
///
/// The square error falls as n^-p, with p = 1 for independent samples and 1.25 for Sobol points
/// (measured: 1.0 to 1.35). Denoising leaves a share s of it. The share grows with the samples,
/// because less noise hides more detail: s / (1 - s) grows as n^0.55 (measured: 0.3 to 0.7, five
/// scenes, 8 to 128 samples).
DenoisingWorth foresee_denoising(const DenoisingProbe& probe, const RenderSettings& settings,
                                 double limit_samples);

/// Traces and denoises tiles of the picture, at most a fifth of its pixels. Returns nothing if the
/// picture is too small, if tracing the tiles takes too long, or if `settings` list the passes.
/// `tracer` belongs to `scene` and `settings`.
std::optional<DenoisingWorth> denoising_worth(const PathTracer& tracer, const Scene& scene,
                                              const RenderSettings& settings, int threads);

/// Returns the message that denoising does not pay, without a line end.
std::string denoising_does_not_pay(const DenoisingWorth& worth);

}  // namespace parray::plan
