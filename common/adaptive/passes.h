#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "common/adaptive/error_estimate.h"
#include "common/adaptive/placement.h"
#include "common/image/framebuffer.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"

namespace parray::adaptive {

/// Estimates the error of a picture made from the samples, such as a denoised picture. All pixels
/// must have at least 2 samples.
using PictureJudge = std::function<ErrorFigures(const FramebufferView&)>;

/// The setting that ended a picture: samples_per_pixel, target_error, target_half_width,
/// time_limit, or the list `passes`.
enum class StopReason : std::uint8_t { samples, error, half_width, time, passes };
/// Returns the reason as it stands in reports: "samples", "half-width" ...
std::string_view name_of(StopReason reason);

/// The size of the next pass, or the reason why there is none.
struct PassSize {
  std::uint64_t samples = 0;              ///< total over all pixels; 0: the picture is complete
  StopReason stop = StopReason::samples;  ///< why the picture is complete
  /// Expected samples of the finished picture, over all pixels, from what is known now; 0: unknown.
  /// The picture gets fewer samples if the time limit ends it.
  std::uint64_t expected = 0;
  /// Error of the present picture if a target needed its estimate; with target_denoised, that of
  /// the denoised picture. If the estimate ends the picture, it covers all rows.
  ErrorEstimate error{};
};

/// Samples per pixel of the first pass of a picture with a target: enough to estimate its error.
inline constexpr std::uint64_t first_samples = 8;
/// Samples per pixel from which the noise is known well enough to place further samples by it. The
/// first pass of a picture without a target that could be met earlier has that many, too.
inline constexpr std::uint64_t pilot_samples = 32;
/// Returns the share of the present square error that a pass should aim at. `share`, 0 < share <=
/// 1, is the share that meets the target. The result is `share` for independent samples. For Sobol
/// points it is larger: it assumes that the error falls with their number, not with its root, which
/// is sometimes so just below powers of two.
double share_to_go_for(double share, Sampler sampler);
/// Returns the samples that are lacking, over all pixels. `traced`: the present number. `total`:
/// the number that is expected to meet an RMSE target. The result includes a margin, so that the
/// last small step does not take many passes.
double lacking_for_error(double total, double traced);
/// Returns the samples of the next pass, over all pixels, at most `lacking`. An early pass adds
/// only a part of `lacking`, because its samples improve the next prediction. The last pass adds
/// all of it. `traced`: the present number.
std::uint64_t part_of(std::uint64_t lacking, std::uint64_t traced);
/// Returns as many of `wanted` samples as the remaining time allows. `traced`: the present number.
/// `affordable`: samples that can be traced in the remaining time. The result is at most half of
/// `affordable`, so that a pass that takes twice as long as predicted still ends in time. 0: the
/// remaining time is too short for a pass of useful size.
std::uint64_t within_time(std::uint64_t wanted, std::uint64_t traced, std::uint64_t affordable);

/// Samples, over all pixels, that the remaining time allows at the speed of the previous pass.
struct Affordable {
  std::uint64_t samples = std::numeric_limits<std::uint64_t>::max();  ///< default: no limit
  /// The part of `samples` that cannot be traced once every pixel has two samples, because the
  /// final estimate of the picture's error takes that much time.
  std::uint64_t stating = 0;
};

/// Returns the size of pass number `pass` (0: the first), from the limits of `settings` and the
/// results of the previous passes. `affordable` is used only under a time limit. The result depends
/// on the arguments alone and is the same on every machine.
///
/// The first pass has first_samples per pixel with a target, otherwise pilot_samples, or fewer if
/// samples_per_pixel is lower. Later passes double or quadruple the picture until the last pass
/// adds all that is lacking. The upper end of the RMSE's confidence interval must meet a target
/// error. 99 % of the pixels and channels must meet a target half-width. The first target that is
/// met ends the picture. The gain of evenly spread points is not known in advance. With such points
/// the passes approach a target in steps that do not overshoot it.
///
/// With target_denoised, `judge` estimates the error of the denoised picture. The estimate costs as
/// much as many samples, and the error of a filtered picture falls more slowly than that of
/// samples. So each pass adds at least half and at most three times the present samples.
///
/// Under a time limit the first pass has one sample in each of some thousand pixels. These samples
/// exist even if the time is very short. Later passes add nested_lattices() until each pixel has
/// one sample, then two; they add several lattices at once if time allows. A pass is sized
/// for at most half of the remaining time at the speed of the previous one; rounding up to whole
/// samples per pixel may exceed the half. No pass follows that would be too small to matter.
///
/// A pass adds exactly that many samples, with one exception: if its size or counts of pixels are
/// odd, an adaptive pass may add one more or one fewer (see Placement::counts()). The sizes of the
/// passes determine the counts of all pixels. So settings.passes from a report repeats the picture
/// if `adaptive` and the kind of target are the same.
///
/// `placement` is that of `state` and `settings`. Afterwards its counts() or even_counts() give the
/// samples of each pixel.
PassSize next_pass_size(const FramebufferView& state, const RenderSettings& settings,
                        std::uint32_t pass, Placement& placement, const Affordable& affordable = {},
                        const PictureJudge& judge = {});

/// Returns the lattices to trace in a pass of `samples` that gives only some of the pixels their
/// first or second sample. `traced` is the number of samples before the pass, over all pixels. The
/// pass consists of whole lattices and may have more samples than `samples`. Returns an empty list
/// for any other pass; then Placement::counts() gives the counts.
std::vector<Stage> lattices_of_pass(std::uint32_t width, std::uint32_t height, std::uint64_t traced,
                                    std::uint64_t samples);

/// Checks the passes of settings.passes that begin before every pixel has two samples: a render
/// could have made them if they consist of whole lattices. Returns a phrase for messages that says
/// which pass is impossible, for example because a user invented it; "" if none is.
std::string problem_with_first_passes(const RenderSettings& settings);

}  // namespace parray::adaptive
