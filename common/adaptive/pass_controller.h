#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/framebuffer.h"
#include "common/scene/settings.h"
#include "common/schedule/work_plan.h"

namespace parray::adaptive {

/// How long a picture has taken so far, in seconds: what passes under a time limit are sized by.
struct PassTimes {
  double total = 0;     ///< with all that must come before and after tracing
  double pass = 0;      ///< tracing the latest pass alone; 0: not known
  double deciding = 0;  ///< deciding on the next pass, as far as can be told
  double stating = 0;   ///< stating the picture's error at the end
};

/// The passes of one picture, whoever traces them: decides what each is to add, from the sums of
/// those before. A picture that does not go in passes has one or, if it is `progressive`, three at
/// most: one sample of each pixel, coarse lattices first; some; all. Plain state; one thread.
class PassController {
 public:
  /// `begun`: samples of the passes that have begun in an earlier life of the job, all pixels
  /// together; they are repeated, not decided anew.
  /// `judge`: of the denoised picture, where the settings have that as their target. Throws
  /// std::logic_error where it is needed and missing.
  PassController(const RenderSettings& settings, double largest_radiance,
                 std::vector<std::uint64_t> begun = {}, PictureJudge judge = {});

  /// Begins the next pass: all samples of the one before are in `framebuffer`. None when the
  /// picture is complete, which it never is before the first.
  std::optional<Pass> next(const Framebuffer& framebuffer, const PassTimes& times = {});

  /// What is in `framebuffer` now was not traced in the time that PassTimes::pass will count.
  void begin_timing(const Framebuffer& framebuffer) {
    samples_before_ = framebuffer.counts().samples;
  }

  /// Number of the pass under way, from 0. Only once one has begun.
  [[nodiscard]] std::uint32_t pass() const { return passes_ - 1; }
  /// Samples of each pass that has begun, for whoever keeps the job; empty without passes.
  [[nodiscard]] const std::vector<std::uint64_t>& begun() const { return begun_; }
  /// Whether the latest pass repeats one of an earlier life.
  [[nodiscard]] bool repeats() const { return repeats_; }
  [[nodiscard]] StopReason stopped_by() const { return stopped_by_; }
  /// Of the finished picture, as far as can be told now; 0: unknown.
  [[nodiscard]] std::uint64_t expected_samples() const { return expected_; }
  /// Of the passes that were complete when a target last had it estimated; not known before that.
  [[nodiscard]] const ErrorFigures& error() const { return error_; }
  /// Of the finished picture, where a target of half-widths had it estimated; else unknown.
  [[nodiscard]] const ErrorEstimate& final_error() const { return final_error_; }

 private:
  [[nodiscard]] Affordable affordable(const Framebuffer& framebuffer, const PassTimes& times) const;
  [[nodiscard]] PassSize decide(const Framebuffer& framebuffer, Placement& placement,
                                const PassTimes& times) const;
  [[nodiscard]] static std::optional<Pass> pass_of(const Framebuffer& framebuffer,
                                                   Placement& placement, std::uint64_t samples);
  [[nodiscard]] std::optional<Pass> next_undecided(const Framebuffer& framebuffer);

  RenderSettings settings_;
  double largest_radiance_;
  std::vector<std::uint64_t> begun_;
  PictureJudge judge_;
  std::uint32_t passes_ = 0;
  std::uint64_t samples_before_ = 0;  ///< the latest pass
  bool repeats_ = false;
  StopReason stopped_by_ = StopReason::samples;
  std::uint64_t expected_ = 0;
  ErrorFigures error_;
  ErrorEstimate final_error_;
  NoiseWeights noise_weights_;
};

}  // namespace parray::adaptive
