#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

#include "common/adaptive/error_estimate.h"
#include "common/adaptive/placement.h"
#include "common/image/framebuffer.h"
#include "common/scene/settings.h"
#include "common/schedule/cell_grid.h"

namespace parray::adaptive {

/// The error of what is made of the samples, such as a denoised picture; all pixels have at
/// least 2.
using PictureJudge = std::function<ErrorFigures(const FramebufferView&)>;

enum class StopReason : std::uint8_t { samples, error, half_width, time, passes };
std::string_view name_of(StopReason reason);

/// How large the next pass is to be, or why there is none.
struct PassSize {
  std::uint64_t samples = 0;  ///< of all pixels together; 0: the picture is done
  StopReason stop = StopReason::samples;
  /// Samples that the finished picture is going to have, as far as can be told now; 0: nothing is
  /// known yet. More than there will be if time runs out.
  std::uint64_t expected = 0;
  /// Of what there is, where a target had it estimated: of all rows if that ends the picture.
  ErrorEstimate error{};
};

/// Samples a pixel with which a picture begins that has a target: enough to tell its error.
inline constexpr std::uint64_t first_samples = 8;
/// Samples a pixel with which the noise is known well enough to place more by it, and with which a
/// picture begins that has no target to meet earlier.
inline constexpr std::uint64_t pilot_samples = 32;
/// The share of the present square error to go for, where a target is `share` of it, 0 < share <=
/// 1: for evenly spread points as if the error fell with their number, not with its root, as it
/// does at times just below powers of two.
double share_to_go_for(double share, Sampler sampler);
/// Samples to add to `traced` where `total` are expected to meet a target of RMSE: some, lest the
/// last little bit takes many passes.
double lacking_for_error(double total, double traced);
/// Of `lacking` samples, those of the next pass: early passes learn, the last one goes all the way.
std::uint64_t part_of(std::uint64_t lacking, std::uint64_t traced);
/// As much of `wanted` samples as the time left allows, in which `affordable` can be traced: at
/// most half of it, so that a pass that takes twice as long as the one before still ends in time.
/// 0: time is up.
std::uint64_t within_time(std::uint64_t wanted, std::uint64_t traced, std::uint64_t affordable);

/// Samples that the time left allows, at the speed of the passes before.
struct Affordable {
  std::uint64_t samples = std::numeric_limits<std::uint64_t>::max();
  /// Of those, how many there are no longer once every pixel has two: the time that it takes to
  /// state the picture's error.
  std::uint64_t stating = 0;
};

/// The size of pass number `pass` (0: the first), from the limits of `settings` and what the passes
/// before it have found. `affordable` is only asked for with a time limit. A function of its
/// arguments alone, in arithmetic that is the same everywhere.
///
/// The first pass has first_samples a pixel with a target, else pilot_samples, fewer if
/// samples_per_pixel say so; later ones double or quadruple the picture until the last goes all the
/// way. A target error is met by the upper end of the RMSE's interval, a target half-width by 99 %
/// of the pixels and channels; the first of both targets that is met ends the picture. How much
/// evenly spread points gain is not known beforehand: with these the passes come near a target in
/// steps that do not go beyond it.
///
/// With target_denoised, `judge` says how far the denoised picture is. That costs as much as many
/// samples, and a filter's error falls slower than that of samples: so the passes add half at least
/// of what there is, and no more than thrice as much.
///
/// With a time limit the first pass has one sample each of some thousand pixels, which are there
/// however short the time is. Later ones add nested_lattices() until each pixel has one sample,
/// then two, or go to several at once where time allows. No pass takes more than half of the time
/// left, at the speed of the one before; there is none when it would be too small to matter.
///
/// A pass adds exactly that many samples (see Placement::counts()), so that settings.passes from a
/// report repeats the picture, if `adaptive` and which target is set are the same.
PassSize next_pass_size(const FramebufferView& state, const RenderSettings& settings,
                        std::uint32_t pass, const Affordable& affordable = {},
                        const PictureJudge& judge = {});
/// The same with a Placement of `state` and `settings`, which the pass's counts can be had from.
PassSize next_pass_size(const FramebufferView& state, const RenderSettings& settings,
                        std::uint32_t pass, Placement& placement, const Affordable& affordable = {},
                        const PictureJudge& judge = {});

/// The pass of `samples` where it leaves some pixels with one sample, or two, fewer than others:
/// lattices that have not been traced yet. Empty: it does not; Placement::counts() says which.
/// `traced`: samples before it, all pixels together. More samples than asked for where a lattice
/// has more.
std::vector<Stage> lattices_of_pass(std::uint32_t width, std::uint32_t height, std::uint64_t traced,
                                    std::uint64_t samples);

}  // namespace parray::adaptive
