#include "common/adaptive/placement.h"

#include <algorithm>
#include <span>

#include "common/adaptive/passes.h"
#include "common/scene/limits.h"
#include "common/scene/stop_settings.h"

namespace parray::adaptive {
namespace {

/// Number of pixels of a large picture that predict the effect of more samples.
constexpr std::size_t asked = std::size_t{1} << 15;

/// Returns the present counts as weights, and 0 for pixels with the fewest samples: they may have
/// more than their share.
std::vector<float> present_shares(std::span<const std::uint32_t> counts, std::uint32_t least) {
  std::vector<float> weights(counts.size());
  std::ranges::transform(counts, weights.begin(), [least](std::uint32_t count) {
    return count > least ? static_cast<float>(count) : 0;
  });
  return weights;
}

}  // namespace

bool is_little(std::uint64_t samples, std::uint64_t traced) { return samples < traced / 3; }

Placement::Placement(const FramebufferView& state, const StopSettings& settings,
                     NoiseWeights* found)
    : state_(state),
      adaptive_(settings.adaptive),
      half_widths_(settings.target_half_width > 0),
      stride_(std::max<std::size_t>(1, state.counts.size() / asked)),
      least_(state.counts.front()),
      most_(least_),
      found_(found) {
  for (const std::uint32_t count : state.counts) {
    traced_ += count;
    least_ = std::min(least_, count);
    most_ = std::max(most_, count);
  }
}

Placement::Kind Placement::kind_of(std::uint64_t samples) {
  if (!adaptive_ || least_ < pilot_samples) return Kind::even;
  if (least_ < most_) {
    return half_widths_ || !is_little(samples, traced_) ? Kind::by_noise : Kind::as_before;
  }
  if (half_widths_) {  // the target concerns the few worst pixels
    return Kind::by_noise;
  }
  if (samples < traced_ / 2) {  // finding their places takes as long as tracing some of them
    return Kind::even;
  }
  constexpr double well = 0.9;
  if (!pays_) pays_ = prediction().relative_cost(0.5, state_.rays_per_sample) < well;
  return *pays_ ? Kind::by_noise : Kind::even;
}

const Allocation& Placement::prediction() {
  if (!prediction_) prediction_.emplace(state_, half_widths_, stride_);
  return *prediction_;
}

double Placement::total_for(double share) {
  const auto traced = static_cast<double>(traced_);
  constexpr double most = 1e18;  // far beyond any picture, and still a 64-bit number
  const double lacking = std::min(traced / share - traced, most);
  switch (kind_of(static_cast<std::uint64_t>(lacking))) {
    case Kind::even: return traced / share;
    case Kind::as_before: {
      const std::vector<float> weights = present_shares(state_.counts, least_);
      return SampleShares(state_.counts, weights).total_at(1 / share);
    }
    case Kind::by_noise: break;
  }
  const Allocation& some = prediction();
  const double total =
      half_widths_ ? some.total_for_square_half_width(share) : some.total_for_square_error(share);
  return traced * (total / some.shares().total_at(0));
}

std::vector<std::uint32_t> Placement::by_noise(double total) {
  NoiseWeights own;
  NoiseWeights& found = found_ != nullptr ? *found_ : own;
  if (found.weights.empty() || traced_ >= 2 * found.samples) {
    const bool whole = prediction_ && stride_ == 1;
    const Allocation all = whole ? *prediction_ : Allocation(state_, half_widths_);
    found = {all.weights(), traced_};
  }
  return SampleShares(state_.counts, found.weights).counts_of(total);
}

std::vector<std::uint32_t> Placement::counts(std::uint64_t samples) {
  const std::uint64_t total = traced_ + samples;
  switch (kind_of(samples)) {
    case Kind::by_noise: return by_noise(static_cast<double>(total));
    case Kind::as_before: {
      const std::vector<float> weights = present_shares(state_.counts, least_);
      return SampleShares(state_.counts, weights).counts_of(static_cast<double>(total));
    }
    case Kind::even: break;
  }
  const std::uint32_t each = each_of(total);
  std::vector<std::uint32_t> counts(state_.counts.begin(), state_.counts.end());
  for (std::uint32_t& count : counts) count = std::max(count, each);
  return counts;
}

std::uint32_t Placement::each_of(std::uint64_t total) const {
  const std::uint64_t pixels = state_.counts.size();
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>((total + pixels - 1) / pixels, limits::max_samples_per_pixel));
}

std::pair<std::uint32_t, std::uint32_t> Placement::even_counts(std::uint64_t samples) {
  if (least_ < most_ || !is_even(samples)) return {0, 0};
  return {least_, std::max(least_, each_of(traced_ + samples))};
}

}  // namespace parray::adaptive
