#pragma once

#include <optional>
#include <string>

#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path_tracer.h"

namespace parray::plan {

/// Measured on some pixels of a picture.
struct DenoisingProbe {
  double samples = 0;   ///< a pixel
  double raw = 0;       ///< RMSE before denoising
  double denoised = 0;  ///< RMSE after it
  /// Samples a pixel that could be traced while the picture is denoised.
  double samples_instead = 0;
};

/// Two pictures that take the same time. RMSE, linear radiance.
struct DenoisingWorth {
  double samples = 0;       ///< a pixel of the denoised picture
  double denoised = 0;      ///< its error
  double more_samples = 0;  ///< that the other picture has
  double undenoised = 0;    ///< the error of that one

  /// Not unless it is clear that it does not: errors are foreseen to some 15 %.
  [[nodiscard]] bool pays() const { return denoised <= 1.15 * undenoised; }
};

/// Foresees the pictures that `settings` ask for: of so many samples, or that meet their target.
/// `limit_samples`: samples that a time limit allows for a picture that is not denoised; 0: none.
///
/// The square error of samples falls as n^-p, p = 1 for independent ones and 1.25 for Sobol points
/// (measured: 1.0 to 1.35). Denoising leaves a share s of it that grows with the samples, because
/// less noise hides more detail: s / (1 - s) grows as n^0.55 (measured: 0.3 to 0.7, five scenes, 8
/// to 128 samples).
DenoisingWorth foresee_denoising(const DenoisingProbe& probe, const RenderSettings& settings,
                                 double limit_samples);

/// Traces and denoises tiles of the picture, at most a fifth of its pixels. None: the picture is
/// too small for that, tracing them takes too long, or the picture's passes are given. `tracer` was
/// made for `scene` and `settings`.
std::optional<DenoisingWorth> denoising_worth(const PathTracer& tracer, const Scene& scene,
                                              const RenderSettings& settings, int threads);

/// One line, without an end: that denoising does not pay.
std::string denoising_does_not_pay(const DenoisingWorth& worth);

}  // namespace parray::plan
