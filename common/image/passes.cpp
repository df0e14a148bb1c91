#include "common/image/passes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/image/error_estimate.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

constexpr std::uint64_t pilot = 32;  ///< samples a pixel of the first pass
/// A pass cut short by the time that is left traces no less than this share of what there is.
constexpr std::uint64_t smallest_share = 64;

std::uint64_t even_up(std::uint64_t samples) { return samples + (samples & 1); }

/// Samples, all pixels together, at which the picture is expected to meet its targets.
std::uint64_t expected_end(double traced, double ratio, std::uint64_t most) {
  const double end = traced * ratio * ratio * 1.02;
  return end < static_cast<double>(most) ? static_cast<std::uint64_t>(end) : most;
}

}  // namespace

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

PassSize next_pass_size(const PictureState& state, const RenderSettings& settings,
                        std::uint32_t pass, std::uint64_t affordable) {
  if (!settings.passes.empty()) {
    return {pass < settings.passes.size() ? settings.passes[pass] : 0, StopReason::passes};
  }
  const std::uint64_t pixels = std::uint64_t{state.width} * state.height;
  const std::uint64_t total = pixels * settings.samples_per_pixel;
  std::uint64_t traced = 0;
  for (const std::uint32_t count : state.counts) {
    traced += count;
  }
  if (traced >= total) {
    return {0, StopReason::samples};
  }
  const std::uint64_t left = total - traced;
  if (!settings.in_passes()) {
    return {left, StopReason::samples};
  }
  std::uint64_t end = total;
  if (traced > 0 && (settings.target_error > 0 || settings.target_half_width > 0)) {
    const ErrorEstimate error = estimate_error(state);
    if (settings.target_error > 0 && error.rmse >= 0) {
      if (error.high <= settings.target_error) {
        return {0, StopReason::error};
      }
      end = expected_end(static_cast<double>(traced), error.high / settings.target_error, end);
    }
    if (settings.target_half_width > 0 && error.rmse >= 0) {
      if (error.half_width_p99 <= settings.target_half_width) {
        return {0, StopReason::half_width};
      }
      end = std::min(end, expected_end(static_cast<double>(traced),
                                       error.half_width_p99 / settings.target_half_width, total));
    }
  }
  std::uint64_t size = std::min(left, traced == 0 ? pilot * pixels : traced);
  size = std::min(size, std::max(end - traced, traced / smallest_share));
  if (size < affordable) {
    const bool ends = size == left;
    return {ends || size <= affordable / 2 ? size : std::max<std::uint64_t>(affordable / 2, 1),
            StopReason::samples};
  }
  if (affordable / 2 <= traced / smallest_share) {
    return {0, StopReason::time};
  }
  return {affordable / 2, StopReason::samples};
}

std::vector<std::uint32_t> counts_after_pass(const PictureState& state,
                                             const RenderSettings& settings, std::uint32_t /*pass*/,
                                             std::uint64_t samples) {
  const std::uint64_t pixels = state.counts.size();
  std::uint64_t traced = samples;
  for (const std::uint32_t count : state.counts) {
    traced += count;
  }
  const std::uint64_t each = std::min<std::uint64_t>(even_up((traced + pixels - 1) / pixels),
                                                     limits::max_samples_per_pixel);
  const std::uint32_t most =
      settings.passes.empty() ? settings.samples_per_pixel : limits::max_samples_per_pixel;
  std::vector<std::uint32_t> counts(state.counts.begin(), state.counts.end());
  for (std::uint32_t& count : counts) {
    count = std::max(count, static_cast<std::uint32_t>(std::min<std::uint64_t>(each, most)));
  }
  return counts;
}

}  // namespace parray
