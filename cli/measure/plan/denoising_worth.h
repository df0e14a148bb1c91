#pragma once

#include <optional>
#include <string>

#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::plan {

/// Measurements of some pixels of a picture, traced with few samples and denoised.
struct DenoisingProbe {
  double samples = 0;   ///< per pixel
  double raw = 0;       ///< RMSE before denoising
  double denoised = 0;  ///< RMSE after denoising
  /// Additional samples per pixel that could be traced in the time that denoising took.
  double samples_instead = 0;
};

/// Two pictures that take the same time, with and without denoising. Errors are RMSE in linear
/// radiance.
struct DenoisingWorth {
  double samples = 0;       ///< per pixel of the denoised picture
  double denoised = 0;      ///< error of the denoised picture
  double more_samples = 0;  ///< additional samples per pixel of the picture without denoising
  double undenoised = 0;    ///< error of the picture without denoising

  /// Returns whether denoising pays. Ignores a small disadvantage, because predictions of errors
  /// have an uncertainty of about 15 %.
  [[nodiscard]] bool pays() const { return denoised <= 1.15 * undenoised; }
};

/// Predicts the errors of a picture with denoising and of one without, in the same time, for the
/// number of samples or the target of `settings`. `limit_samples`: samples per pixel that a time
/// limit allows without denoising; 0: no limit.
///
/// The model: without denoising, the mean square error falls as n^-p with the number n of samples.
/// p is 1 for independent samples and 1.25 for Sobol points (measured: 1.0 to 1.35). Denoising
/// leaves a share s of the mean square error. The share grows with n, because less noise hides more
/// detail: s / (1 - s) grows as n^0.55 (measured: 0.3 to 0.7, five scenes, 8 to 128 samples).
DenoisingWorth foresee_denoising(const DenoisingProbe& probe, const RenderSettings& settings,
                                 double limit_samples);

/// Traces and denoises tiles of the picture, at most a fifth of its pixels, and predicts from them.
/// Returns nothing if the picture is too small or has no noise, or if tracing the tiles takes
/// longer than 1/20 of the time limit (without a limit: 1 s). Also returns nothing if `settings`
/// have fewer than 2 samples or list the passes. `tracer` must be made from `scene` and `settings`.
std::optional<DenoisingWorth> denoising_worth(const PathTracer& tracer, const Scene& scene,
                                              const RenderSettings& settings, int threads);

/// Returns the message that denoising does not pay, without a line end.
std::string denoising_does_not_pay(const DenoisingWorth& worth);

}  // namespace parray::plan
