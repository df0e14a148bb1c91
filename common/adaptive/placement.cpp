#include "common/adaptive/placement.h"

#include <algorithm>
#include <numeric>

#include "common/adaptive/passes.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

/// Pixels with the fewest may have more than their share.
SampleShares present_shares(const FramebufferView& state, std::uint32_t least) {
  std::vector<std::uint32_t> counts(state.counts.begin(), state.counts.end());
  std::vector<double> weights(counts.size());
  std::transform(counts.begin(), counts.end(), weights.begin(),
                 [least](std::uint32_t count) { return count > least ? count : 0; });
  return {std::move(counts), std::move(weights)};
}

}  // namespace

bool is_little(std::uint64_t samples, std::uint64_t traced) { return samples < traced / 3; }

Placement::Placement(const FramebufferView& state, const StopSettings& settings)
    : state_(state),
      adaptive_(settings.adaptive),
      half_widths_(settings.target_half_width > 0),
      traced_(std::accumulate(state.counts.begin(), state.counts.end(), std::uint64_t{0})) {
  const auto [least, most] = std::minmax_element(state.counts.begin(), state.counts.end());
  least_ = *least;
  most_ = *most;
}

Placement::Kind Placement::kind_of(std::uint64_t samples) {
  if (!adaptive_ || least_ < pilot_samples) {
    return Kind::even;
  }
  if (least_ < most_) {
    return half_widths_ || !is_little(samples, traced_) ? Kind::by_noise : Kind::as_before;
  }
  if (half_widths_) {  // those of the few worst pixels
    return Kind::by_noise;
  }
  if (samples < traced_ / 2) {  // to find out where they go takes as long as some of them
    return Kind::even;
  }
  if (!pays_) {
    pays_ = adaptive_pays(state_);
  }
  return *pays_ ? Kind::by_noise : Kind::even;
}

const Allocation& Placement::allocation() {
  if (!allocation_) {
    allocation_.emplace(state_, half_widths_);
  }
  return *allocation_;
}

double Placement::total_for(double share) {
  const auto traced = static_cast<double>(traced_);
  constexpr double most = 1e18;  // far beyond any picture's, and a number of 64 bits
  const double lacking = std::min(traced / share - traced, most);
  switch (kind_of(static_cast<std::uint64_t>(lacking))) {
    case Kind::even:
      return traced / share;
    case Kind::as_before:
      return present_shares(state_, least_).total_at(1 / share);
    case Kind::by_noise:
      break;
  }
  return half_widths_ ? allocation().total_for_square_half_width(share)
                      : allocation().total_for_square_error(share);
}

std::vector<std::uint32_t> Placement::counts(std::uint64_t samples) {
  const std::uint64_t total = traced_ + samples;
  switch (kind_of(samples)) {
    case Kind::by_noise:
      return allocation().shares().counts_of(static_cast<double>(total));
    case Kind::as_before:
      return present_shares(state_, least_).counts_of(static_cast<double>(total));
    case Kind::even:
      break;
  }
  const std::uint64_t pixels = state_.counts.size();
  const std::uint64_t each =
      std::min<std::uint64_t>((total + pixels - 1) / pixels, limits::max_samples_per_pixel);
  std::vector<std::uint32_t> counts(state_.counts.begin(), state_.counts.end());
  for (std::uint32_t& count : counts) {
    count = std::max(count, static_cast<std::uint32_t>(each));
  }
  return counts;
}

}  // namespace parray
