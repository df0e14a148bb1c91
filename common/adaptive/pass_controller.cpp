#include "common/adaptive/pass_controller.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/scene/settings.h"

namespace parray::adaptive {
namespace {

/// Returns the pass that brings every pixel from its present number of samples to that in
/// `targets`. Returns nothing if no pixel gets a sample.
std::optional<Pass> pass_to(const Framebuffer& framebuffer,
                            const std::vector<std::uint32_t>& targets) {
  const std::span<const std::uint32_t> now = framebuffer.samples();
  const auto [least_now, most_now] = std::ranges::minmax_element(now);
  const auto [least_then, most_then] = std::ranges::minmax_element(targets);
  if (*most_then <= *least_now) {
    return {};  // no pixel may have more
  }
  Pass pass{{{*least_now, *most_then}}, {}};
  if (*least_now == *most_now && *least_then == *most_then) return pass;
  pass.samples.reserve(targets.size());
  bool any = false;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] < now[i]) throw std::logic_error("a pass would remove samples of a pixel");
    any = any || targets[i] > now[i];
    pass.samples.push_back({now[i], targets[i]});
  }
  return any ? std::optional(std::move(pass)) : std::nullopt;
}

/// Splits a picture's first pass so that its first stage traces one sample of each pixel.
void show_early(Pass& pass) {
  const Stage& all = pass.stages.front();
  if (pass.stages.size() == 1 && pass.samples.empty() && all.begin == 0 && all.end > 1) {
    pass.stages = {{0, 1}, {1, all.end}};
  }
}

}  // namespace

PassController::PassController(const RenderSettings& settings, double largest_radiance,
                               std::vector<std::uint64_t> begun, PictureJudge judge)
    : settings_(settings),
      largest_radiance_(largest_radiance),
      begun_(std::move(begun)),
      judge_(std::move(judge)) {
  if (settings_->target_denoised && settings_->passes.empty() && !judge_) {
    throw std::logic_error("a target for the denoised picture needs a PictureJudge");
  }
}

/// Begins the next pass of a picture without adaptive passes. Workers return all sums once per
/// pass, so a progressive picture has only three.
std::optional<Pass> PassController::next_undecided(const Framebuffer& framebuffer) {
  const std::uint32_t all = settings_->samples_per_pixel;
  const std::uint64_t pixels = framebuffer.samples().size();
  expected_ = pixels * all;
  std::vector<std::uint32_t> ends{all};
  if (settings_->progressive) ends = {1, std::min(16U, all), all};
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  if (passes_ == ends.size()) return {};
  const std::uint32_t begin = passes_ == 0 ? 0 : ends[passes_ - 1];
  Pass pass{{{begin, ends[passes_]}}, {}};
  if (settings_->progressive && begin == 0) {
    pass.stages.clear();
    for (const Lattice& lattice : nested_lattices(framebuffer.width(), framebuffer.height())) {
      pass.stages.emplace_back(0, 1, lattice);
    }
  }
  ++passes_;
  return pass;
}

/// Returns the number of samples that the remaining time allows at the speed of the previous pass.
/// After a restart the speed is unknown, and the next pass adds at most as many samples as the
/// picture has.
Affordable PassController::affordable(const Framebuffer& framebuffer,
                                      const PassTimes& times) const {
  if (settings_->time_limit == 0 || passes_ == 0) return {};
  const std::uint64_t samples = framebuffer.counts().samples;
  if (times.pass <= 0) {
    return {times.total > 0 ? 0 : 2 * samples};  // a pass takes half of these
  }
  constexpr double most = 1e18;  // far beyond any picture, and still a 64-bit number
  const double speed = static_cast<double>(samples - samples_before_) / times.pass;
  const auto samples_in = [speed, most](double seconds) {
    return static_cast<std::uint64_t>(std::clamp(speed * seconds, 0.0, most));
  };
  return {samples_in(settings_->time_limit - times.total - times.deciding),
          samples_in(times.stating)};
}

std::optional<Pass> PassController::pass_of(const Framebuffer& framebuffer, Placement& placement,
                                            std::uint64_t samples) {
  std::vector<Stage> stages = lattices_of_pass(framebuffer.width(), framebuffer.height(),
                                               framebuffer.counts().samples, samples);
  if (!stages.empty()) return Pass{std::move(stages), {}};
  if (const auto [now, then] = placement.even_counts(samples); then > now) {
    return Pass{{{now, then}}, {}};
  }
  return pass_to(framebuffer, placement.counts(samples));
}

PassSize PassController::decide(const Framebuffer& framebuffer, Placement& placement,
                                const PassTimes& times) const {
  return next_pass_size(framebuffer.view(largest_radiance_), settings_, passes_, placement,
                        affordable(framebuffer, times), judge_);
}

std::optional<Pass> PassController::next(const Framebuffer& framebuffer, const PassTimes& times) {
  if (!settings_->in_passes()) return next_undecided(framebuffer);
  Placement placement(framebuffer.view(largest_radiance_), settings_, &noise_weights_);
  repeats_ = passes_ < begun_.size();
  PassSize size;
  if (repeats_) {
    size.samples = begun_[passes_];
    expected_ = passes_ == 0 ? decide(framebuffer, placement, times).expected : expected_;
  } else {
    size = decide(framebuffer, placement, times);
    expected_ = size.samples > 0 ? size.expected : framebuffer.counts().samples;
    error_ = size.error.known() ? size.error : error_;
  }
  stopped_by_ = size.stop;
  if (size.samples == 0) {
    if (size.error.half_width.size() == 3 * framebuffer.pixels().size()) {
      final_error_ = std::move(size.error);
    }
    return {};
  }
  auto pass = pass_of(framebuffer, placement, size.samples);
  if (pass) {
    if (settings_->progressive) show_early(*pass);
    samples_before_ = framebuffer.counts().samples;
    ++passes_;
    if (!repeats_) begun_.push_back(size.samples);
  }
  return pass;
}

}  // namespace parray::adaptive
