#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/framebuffer.h"
#include "common/scene/settings_fwd.h"
#include "common/schedule/work_plan.h"

namespace parray::adaptive {

/// Times of a picture, in seconds. They determine the size of the next pass under a time limit.
struct PassTimes {
  double total = 0;     ///< spent so far, plus the expected work after the last sample
  double pass = 0;      ///< tracing of the latest pass; 0: unknown
  double deciding = 0;  ///< estimated time to decide on the next pass
  double stating = 0;   ///< time to estimate the finished picture's error; not in `total`
};

/// Decides what each pass of one picture adds, from the sums of the previous passes. If
/// StopSettings::in_passes() is false, the picture has a single pass, or up to three if it is
/// `progressive`: one sample of each pixel (coarse lattices first), some samples, all samples. Not
/// thread-safe.
class PassController {
 public:
  /// `begun` lists the samples, over all pixels, of each pass that began before a restart of the
  /// job. The controller repeats these passes and does not decide them again. `judge` estimates the
  /// error of the denoised picture. Throws std::logic_error if it is missing and the settings
  /// have a target for that picture and no list of passes.
  PassController(const RenderSettings& settings, double largest_radiance,
                 std::vector<std::uint64_t> begun = {}, PictureJudge judge = {});

  /// Begins the next pass. `framebuffer` must contain all samples of the previous pass. Returns
  /// nothing if the picture is complete; the first call always returns a pass.
  std::optional<Pass> next(const Framebuffer& framebuffer, const PassTimes& times = {});

  /// Notes the samples now in `framebuffer` as older than the time in PassTimes::pass. The speed of
  /// the latest pass is computed from the samples after this call.
  void begin_timing(const Framebuffer& framebuffer) {
    samples_before_ = framebuffer.counts().samples;
  }

  /// Returns the number of the current pass, from 0. Call it only after the first pass has begun.
  [[nodiscard]] std::uint32_t pass() const { return passes_ - 1; }
  /// Returns the samples of each pass that has begun, so that the job can be stored. The list
  /// always includes the passes from before a restart. Empty if StopSettings::in_passes() is false.
  [[nodiscard]] const std::vector<std::uint64_t>& begun() const { return begun_; }
  /// Returns whether the latest pass repeats one from before a restart.
  [[nodiscard]] bool repeats() const { return repeats_; }
  /// Returns why the picture is complete. Valid after next() has returned nothing.
  [[nodiscard]] StopReason stopped_by() const { return stopped_by_; }
  /// Returns the expected samples of the finished picture, over all pixels; 0: unknown.
  [[nodiscard]] std::uint64_t expected_samples() const { return expected_; }
  /// Returns the error of the picture at the last estimate that a target needed; unknown before the
  /// first. With target_denoised it is the error of the denoised picture.
  [[nodiscard]] const ErrorFigures& error() const { return error_; }
  /// Returns the error of the finished picture if a target of half-widths needed its estimate;
  /// otherwise unknown.
  [[nodiscard]] const ErrorEstimate& final_error() const { return final_error_; }

 private:
  [[nodiscard]] Affordable affordable(const Framebuffer& framebuffer, const PassTimes& times) const;
  [[nodiscard]] PassSize decide(const Framebuffer& framebuffer, Placement& placement,
                                const PassTimes& times) const;
  [[nodiscard]] static std::optional<Pass> pass_of(const Framebuffer& framebuffer,
                                                   Placement& placement, std::uint64_t samples);
  [[nodiscard]] std::optional<Pass> next_undecided(const Framebuffer& framebuffer);

  Boxed<RenderSettings> settings_;
  double largest_radiance_;
  std::vector<std::uint64_t> begun_;
  PictureJudge judge_;
  std::uint32_t passes_ = 0;
  std::uint64_t samples_before_ = 0;  ///< samples before the latest pass
  bool repeats_ = false;
  StopReason stopped_by_ = StopReason::samples;
  std::uint64_t expected_ = 0;
  ErrorFigures error_;
  ErrorEstimate final_error_;
  NoiseWeights noise_weights_;
};

}  // namespace parray::adaptive
