#include "common/adaptive/passes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "common/scene/settings.h"

namespace parray::adaptive {
namespace {

std::uint64_t pixels_of(const FramebufferView& state) {
  return std::uint64_t{state.width} * state.height;
}

/// What the picture still lacks for its denoised one to meet a target.
PassSize towards_denoised(const FramebufferView& state, double target, std::uint64_t samples,
                          std::uint64_t most, const PictureJudge& judge) {
  const ErrorEstimate error{judge(state), {}};
  if (error.high <= target) return {0, StopReason::error, 0, error};
  const auto traced = static_cast<double>(samples);
  const double share = target * target / (error.high * error.high);
  const double lacking = std::clamp(traced / share - traced, traced / 2, 3 * traced);
  return {std::min(most, static_cast<std::uint64_t>(lacking)), StopReason::samples, 0, error};
}

/// Limits for an estimate from some rows of a large picture. The rows prove that a target is missed
/// if their error exceeds it by these factors. In measurements, some rows differed from all rows by
/// less.
struct Look {
  std::size_t pixels;
  double error;
  double half_width;
  /// Least stride between rows. A closer look reads nearly all rows, either for themselves or for
  /// the rows beside them.
  std::size_t least_stride;
};
constexpr std::array<Look, 2> looks{
    {{std::size_t{1} << 14, 1.06, 1.03, 2}, {std::size_t{1} << 16, 1.015, 1.01, 8}}};

/// Returns the error of every `stride`-th row. Its interval is scaled to the width that all rows
/// would give.
ErrorEstimate error_of_rows(const FramebufferView& state, bool widths, std::size_t stride) {
  ErrorEstimate error = widths ? estimate_error(state, stride) : estimate_rmse(state, stride);
  error.high = error.rmse + (error.high - error.rmse) / std::sqrt(static_cast<double>(stride));
  return error;
}

/// Returns the picture's error. Returns the error of some rows if it already shows that the targets
/// are missed.
ErrorEstimate error_of(const FramebufferView& state, const StopSettings& settings) {
  const bool widths = settings.target_half_width > 0;
  for (const Look& look : looks) {
    const std::size_t stride = state.pixels.size() / look.pixels;
    if (stride < (widths ? look.least_stride : 2)) continue;
    ErrorEstimate some = error_of_rows(state, widths, stride);
    if (some.high > look.error * settings.target_error &&
        (!widths || some.half_width_p99 > look.half_width * settings.target_half_width)) {
      return some;
    }
  }
  return widths ? estimate_error(state) : estimate_rmse(state);
}

/// Returns how many times the samples that share_to_go_for() aims at the picture probably needs in
/// the end. With Sobol points, the error falls with the power -2/3 of the number of samples in most
/// scenes, and the passes aim at less.
double more_than_aimed_at(double share, Sampler sampler) {
  return sampler == Sampler::sobol ? 1 / std::sqrt(std::sqrt(share)) : 1;
}

/// Returns the samples that the picture still lacks to meet its targets, or the reason why it is
/// complete.
PassSize towards_targets(const FramebufferView& state, const RenderSettings& settings,
                         std::uint64_t most, const PictureJudge& judge, Placement& placement) {
  if (settings.target_denoised) {
    return towards_denoised(state, settings.target_error, placement.traced(), most, judge);
  }
  const bool widths = settings.target_half_width > 0;
  ErrorEstimate error = error_of(state, settings);
  if (!error.known()) return {most};
  double share = 0;
  if (settings.target_error > 0) {
    if (error.high <= settings.target_error) return {0, StopReason::error, 0, std::move(error)};
    share = settings.target_error / error.high;
  }
  if (widths) {
    if (error.half_width_p99 <= settings.target_half_width) {
      return {0, StopReason::half_width, 0, std::move(error)};
    }
    share = std::max(share, settings.target_half_width / error.half_width_p99);
  }
  const double total = placement.total_for(share_to_go_for(share * share, settings.sampler));
  const auto traced = static_cast<double>(placement.traced());
  // Half-widths of single pixels are harder to predict than the error of the whole picture.
  const double lacking =
      widths ? std::max((total - traced) * 1.1, traced / 16) : lacking_for_error(total, traced);
  const std::uint64_t wanted =
      lacking < static_cast<double>(most) ? static_cast<std::uint64_t>(lacking) + 1 : most;
  const double likely = total * more_than_aimed_at(share * share, settings.sampler);
  const auto limit = static_cast<double>(placement.traced() + most);
  const auto expected =
      static_cast<std::uint64_t>(std::min(std::max(likely, traced + lacking), limit));
  return {wanted, StopReason::samples, expected, std::move(error)};
}

/// Sizes a pass under a time limit while some pixels have fewer than two samples: as much as half
/// of the remaining time allows. The pass consists of whole pairs if the time allows them,
/// otherwise of lattices.
PassSize towards_pairs(const FramebufferView& state, std::uint64_t traced, std::uint64_t left,
                       const Affordable& affordable) {
  const std::uint64_t pixels = pixels_of(state);
  if (traced == 0) {
    return {nested_lattices(state.width, state.height).front().pixels(state.width, state.height)};
  }
  const std::uint64_t room = affordable.samples / 2;
  const std::uint64_t stated =
      affordable.samples > affordable.stating ? (affordable.samples - affordable.stating) / 2 : 0;
  if (const std::uint64_t pairs = (traced + stated) / (2 * pixels); pairs > 0) {
    return {
        std::min(left, std::min(pairs, std::uint64_t{pilot_samples / 2}) * 2 * pixels - traced)};
  }
  std::uint64_t end = traced / pixels * pixels;  // of the samples with one lattice more
  std::uint64_t most = 0;
  for (const Lattice& lattice : nested_lattices(state.width, state.height)) {
    end += lattice.pixels(state.width, state.height);
    // With the second sample of its last pixel the picture has an error to state.
    if (end > traced && end - traced <= (end < 2 * pixels ? room : stated)) most = end - traced;
  }
  return {std::min(left, most), most > 0 ? StopReason::samples : StopReason::time};
}

/// Rounds the size of a pass that gives every pixel the same number of samples.
PassSize whole_layers(PassSize size, const StopSettings& settings, std::uint64_t left,
                      std::uint64_t pixels, std::uint64_t affordable) {
  if (size.samples == 0) return size;
  size.samples = std::min(left, (size.samples + pixels - 1) / pixels * pixels);
  if (settings.time_limit > 0 && size.samples > affordable) {
    size.samples = std::min(left, affordable / pixels * pixels);
    size.stop = size.samples > 0 ? size.stop : StopReason::time;
  }
  return size;
}

/// Rounds the size of an adaptive pass to pairs of samples.
PassSize pairs(PassSize size) {
  size.samples = size.samples > 0 ? std::max<std::uint64_t>(size.samples / 2 * 2, 2) : 0;
  return size;
}

}  // namespace

double share_to_go_for(double share, Sampler sampler) {
  return sampler == Sampler::sobol ? std::sqrt(share) : share;
}

double lacking_for_error(double total, double traced) {
  return std::max((total - traced) * 1.01, traced / 64);
}

std::uint64_t part_of(std::uint64_t lacking, std::uint64_t traced) {
  if (lacking > 7 * traced) return 3 * traced;
  return lacking > 2 * traced ? traced : lacking;
}

std::uint64_t within_time(std::uint64_t wanted, std::uint64_t traced, std::uint64_t affordable) {
  if (wanted > affordable / 2 && affordable < traced / 32) return 0;
  return std::min(wanted, affordable / 2);
}

std::string_view name_of(StopReason reason) {
  switch (reason) {
    case StopReason::samples: return "samples";
    case StopReason::error: return "error";
    case StopReason::half_width: return "half-width";
    case StopReason::time: return "time";
    case StopReason::passes: return "passes";
  }
  throw std::logic_error("unknown stop reason");
}

PassSize next_pass_size(const FramebufferView& state, const RenderSettings& settings,
                        std::uint32_t pass, Placement& placement, const Affordable& affordable,
                        const PictureJudge& judge) {
  if (!settings.passes.empty()) {
    return {pass < settings.passes.size() ? settings.passes[pass] : 0, StopReason::passes,
            std::accumulate(settings.passes.begin(), settings.passes.end(), std::uint64_t{0})};
  }
  const std::uint64_t pixels = pixels_of(state);
  const std::uint64_t traced = placement.traced();
  const std::uint64_t total = pixels * settings.samples_per_pixel;
  // Adaptive passes trace pairs; a picture of one sample in all has one pass even so.
  if (traced + (settings.adaptive && traced > 0 ? 1 : 0) >= total) return {0, StopReason::samples};
  const std::uint64_t left = total - traced;
  if (!settings.in_passes()) return {left, StopReason::samples, total};
  const bool targets = settings.target_error > 0 || settings.target_half_width > 0;
  if (settings.time_limit > 0 && traced < 2 * pixels) {
    PassSize size = towards_pairs(state, traced, left, affordable);
    size.expected = targets ? 0 : total;
    return size;
  }
  if (traced == 0) {
    return {std::min(left, (targets ? first_samples : pilot_samples) * pixels), StopReason::samples,
            targets ? 0 : total};
  }
  PassSize wanted{left};
  if (targets) {
    wanted = towards_targets(state, settings, left, judge, placement);
    if (wanted.samples == 0) return wanted;
  }
  wanted.expected = std::max(wanted.expected, traced + wanted.samples);
  if (!settings.target_denoised) wanted.samples = part_of(wanted.samples, traced);
  const std::uint64_t pilot = pilot_samples * pixels;
  if (settings.adaptive && traced < pilot) {
    wanted.samples = std::min(wanted.samples, pilot - traced);
  }
  const std::uint64_t can =
      affordable.samples > affordable.stating ? affordable.samples - affordable.stating : 0;
  if (settings.time_limit > 0) {
    wanted.samples = within_time(wanted.samples, traced, can);
    wanted.stop = wanted.samples > 0 ? wanted.stop : StopReason::time;
  }
  return placement.is_even(wanted.samples) ? whole_layers(wanted, settings, left, pixels, can)
                                           : pairs(wanted);
}

std::vector<Stage> lattices_of_pass(std::uint32_t width, std::uint32_t height, std::uint64_t traced,
                                    std::uint64_t samples) {
  const std::uint64_t pixels = std::uint64_t{width} * height;
  const std::uint64_t layer = traced / pixels;
  const bool whole = traced % pixels == 0 && samples >= pixels;
  if (layer >= 2 || whole || samples > pixels - traced % pixels) return {};
  const auto sample = static_cast<std::uint32_t>(layer);
  std::vector<Stage> stages;
  std::uint64_t end = layer * pixels;
  for (const Lattice& lattice : nested_lattices(width, height)) {
    if (end >= traced + samples) break;
    if (end >= traced) stages.emplace_back(sample, sample + 1, lattice);
    end += lattice.pixels(width, height);
  }
  return stages;
}

std::string problem_with_first_passes(const RenderSettings& settings) {
  const std::uint64_t pixels = pixel_count(settings);
  std::uint64_t traced = 0;
  for (const std::uint64_t samples : settings.passes) {
    if (traced + samples >= 2 * pixels) break;
    std::uint64_t whole = (traced + samples) % pixels == 0 ? samples : 0;
    for (const Stage& stage : lattices_of_pass(settings.width, settings.height, traced, samples)) {
      whole += whole == samples ? 0 : stage.lattice.pixels(settings.width, settings.height);
    }
    if (whole != samples) {
      return "a picture of " + std::to_string(settings.width) + " x " +
             std::to_string(settings.height) + " pixels that has " + std::to_string(traced) +
             " samples cannot get a pass of " + std::to_string(samples);
    }
    traced += samples;
  }
  return {};
}

}  // namespace parray::adaptive
