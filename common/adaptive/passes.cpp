#include "common/adaptive/passes.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "common/adaptive/allocation.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

std::uint64_t pixels_of(const FramebufferView& state) {
  return std::uint64_t{state.width} * state.height;
}

std::uint64_t samples_of(const FramebufferView& state) {
  return std::accumulate(state.counts.begin(), state.counts.end(), std::uint64_t{0});
}

/// Samples, all pixels together, at which the picture is expected to meet a target: its square is
/// `share` of what there is.
double expected_total(const FramebufferView& state, const StopSettings& settings, double share) {
  if (!settings.adaptive) {
    return static_cast<double>(samples_of(state)) / share;
  }
  const bool half_widths = settings.target_half_width > 0;
  const Allocation allocation(state, half_widths);
  return half_widths ? allocation.total_for_square_half_width(share)
                     : allocation.total_for_square_error(share);
}

/// What the picture still lacks of the targets: samples, or why it is done.
PassSize towards_targets(const FramebufferView& state, const StopSettings& settings,
                         std::uint64_t most) {
  const bool widths = settings.target_half_width > 0;
  const ErrorFigures error = widths ? estimate_error(state) : estimate_rmse(state);
  if (!error.known()) {
    return {most};
  }
  double share = 0;
  if (settings.target_error > 0) {
    if (error.high <= settings.target_error) {
      return {0, StopReason::error, 0, error};
    }
    share = settings.target_error / error.high;
  }
  if (widths) {
    if (error.half_width_p99 <= settings.target_half_width) {
      return {0, StopReason::half_width, 0, error};
    }
    share = std::max(share, settings.target_half_width / error.half_width_p99);
  }
  const double total = expected_total(state, settings, share * share);
  const auto traced = static_cast<double>(samples_of(state));
  // Half-widths of single pixels are harder to foresee than the error of them all.
  const double lacking =
      widths ? std::max((total - traced) * 1.1, traced / 8) : lacking_for_error(total, traced);
  const std::uint64_t wanted =
      lacking < static_cast<double>(most) ? static_cast<std::uint64_t>(lacking) + 1 : most;
  return {wanted, StopReason::samples, 0, error};
}

/// Of a picture that has fewer than two samples of each pixel, and a time limit: as much as half of
/// the time left allows. Whole pairs where it is enough for them, else lattices.
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
    if (end > traced && end - traced <= (end < 2 * pixels ? room : stated)) {
      most = end - traced;
    }
  }
  return {std::min(left, most), most > 0 ? StopReason::samples : StopReason::time};
}

/// Uniform passes give every pixel the same, in pairs but for the last sample of an odd number.
PassSize whole_pairs(PassSize size, const StopSettings& settings, std::uint64_t left,
                     std::uint64_t pixels, std::uint64_t affordable) {
  if (size.samples == 0 || settings.adaptive) {
    size.samples = size.samples > 0 ? std::max<std::uint64_t>(size.samples / 2 * 2, 2) : 0;
    return size;
  }
  const std::uint64_t pairs = (size.samples + 2 * pixels - 1) / (2 * pixels);
  size.samples = std::min(left, pairs * 2 * pixels);
  if (settings.time_limit > 0 && size.samples > affordable) {
    size.samples = std::min(left, affordable / (2 * pixels) * 2 * pixels);
    size.stop = size.samples > 0 ? size.stop : StopReason::time;
  }
  return size;
}

}  // namespace

double lacking_for_error(double total, double traced) {
  return std::max((total - traced) * 1.03, traced / 32);
}

std::uint64_t part_of(std::uint64_t lacking, std::uint64_t traced) {
  if (lacking > 7 * traced) {
    return 3 * traced;
  }
  return lacking > 2 * traced ? traced : lacking;
}

std::uint64_t within_time(std::uint64_t wanted, std::uint64_t traced, std::uint64_t affordable) {
  if (wanted > affordable / 2 && affordable < traced / 32) {
    return 0;
  }
  return std::min(wanted, affordable / 2);
}

std::string_view name_of(StopReason reason) {
  switch (reason) {
    case StopReason::samples:
      return "samples";
    case StopReason::error:
      return "error";
    case StopReason::half_width:
      return "half-width";
    case StopReason::time:
      return "time";
    case StopReason::passes:
      return "passes";
  }
  throw std::logic_error("unknown stop reason");
}

PassSize next_pass_size(const FramebufferView& state, const StopSettings& settings,
                        std::uint32_t pass, const Affordable& affordable) {
  if (!settings.passes.empty()) {
    return {pass < settings.passes.size() ? settings.passes[pass] : 0, StopReason::passes,
            std::accumulate(settings.passes.begin(), settings.passes.end(), std::uint64_t{0})};
  }
  const std::uint64_t pixels = pixels_of(state);
  const std::uint64_t traced = samples_of(state);
  const std::uint64_t total = pixels * settings.samples_per_pixel;
  // Adaptive passes trace pairs; a picture of one sample in all has one pass even so.
  if (traced + (settings.adaptive && traced > 0 ? 1 : 0) >= total) {
    return {0, StopReason::samples};
  }
  const std::uint64_t left = total - traced;
  if (!settings.in_passes()) {
    return {left, StopReason::samples, total};
  }
  const bool targets = settings.target_error > 0 || settings.target_half_width > 0;
  if (settings.time_limit > 0 && traced < 2 * pixels) {
    PassSize size = towards_pairs(state, traced, left, affordable);
    size.expected = targets ? 0 : total;
    return size;
  }
  if (traced == 0) {
    return {std::min(left, pilot_samples * pixels), StopReason::samples, targets ? 0 : total};
  }
  PassSize wanted{left};
  if (targets) {
    wanted = towards_targets(state, settings, left);
    if (wanted.samples == 0) {
      return wanted;
    }
  }
  wanted.expected = traced + wanted.samples;
  wanted.samples = part_of(wanted.samples, traced);
  const std::uint64_t can =
      affordable.samples > affordable.stating ? affordable.samples - affordable.stating : 0;
  if (settings.time_limit > 0) {
    wanted.samples = within_time(wanted.samples, traced, can);
    wanted.stop = wanted.samples > 0 ? wanted.stop : StopReason::time;
  }
  return whole_pairs(wanted, settings, left, pixels, can);
}

std::vector<Stage> lattices_of_pass(std::uint32_t width, std::uint32_t height, std::uint64_t traced,
                                    std::uint64_t samples) {
  const std::uint64_t pixels = std::uint64_t{width} * height;
  const std::uint64_t layer = traced / pixels;
  const bool whole = traced % pixels == 0 && samples >= pixels;
  if (layer >= 2 || whole || samples > pixels - traced % pixels) {
    return {};
  }
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

std::vector<std::uint32_t> counts_after_pass(const FramebufferView& state,
                                             const StopSettings& settings, std::uint64_t samples) {
  const std::uint64_t total = samples_of(state) + samples;
  const bool known = std::all_of(state.counts.begin(), state.counts.end(),
                                 [](std::uint32_t count) { return count >= 2; });
  if (settings.adaptive && known) {
    return Allocation(state, settings.target_half_width > 0).counts_of(static_cast<double>(total));
  }
  const std::uint64_t pixels = pixels_of(state);
  const std::uint64_t each =
      std::min<std::uint64_t>((total + pixels - 1) / pixels, limits::max_samples_per_pixel);
  std::vector<std::uint32_t> counts(state.counts.begin(), state.counts.end());
  for (std::uint32_t& count : counts) {
    count = std::max(count, static_cast<std::uint32_t>(each));
  }
  return counts;
}

}  // namespace parray
