#include "common/image/framebuffer.h"

#include <algorithm>
#include <stdexcept>

#include "common/schedule/row_order.h"

namespace parray {

Framebuffer::Framebuffer(const RenderSettings& settings)
    : width_(settings.width),
      height_(settings.height),
      row_at_(make_row_order(settings.row_order, settings.height)),
      pixels_(std::size_t{settings.width} * settings.height),
      samples_(pixels_.size()),
      pass_rect_{0, settings.height, 0, settings.samples_per_pixel} {}

void Framebuffer::begin_pass(const std::vector<std::uint32_t>& targets) {
  if (targets.size() != pixels_.size()) {
    throw std::logic_error("a pass of another image");
  }
  const auto [least_now, most_now] = std::minmax_element(samples_.begin(), samples_.end());
  const auto [least_then, most_then] = std::minmax_element(targets.begin(), targets.end());
  pass_rect_ = {0, height_, *least_now, std::max(*most_then, *least_now)};
  pass_.clear();
  if (*least_now == *most_now && *least_then == *most_then) {
    return;
  }
  pass_.reserve(targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] < samples_[i]) {
      throw std::logic_error("a pass that takes samples away");
    }
    pass_.push_back({samples_[i], targets[i]});
  }
}

std::vector<SampleRange> Framebuffer::samples_of(const WorkRect& rect) const {
  std::vector<SampleRange> samples;
  if (pass_.empty()) {
    return samples;
  }
  samples.reserve(std::size_t{rect.rows()} * width_);
  for (std::uint32_t position = rect.row_begin; position < rect.row_end; ++position) {
    const SampleRange* const row = pass_.data() + std::size_t{row_at_[position]} * width_;
    for (std::uint32_t x = 0; x < width_; ++x) {
      samples.push_back(common_of(row[x], rect.sample_range()));
    }
  }
  return samples;
}

std::uint64_t Framebuffer::sample_count(const WorkRect& rect) const {
  if (pass_.empty()) {
    return rect.units() * width_;
  }
  std::uint64_t count = 0;
  for (const SampleRange& samples : samples_of(rect)) {
    count += samples.count();
  }
  return count;
}

void Framebuffer::merge(const RowBlock& block) {
  const WorkRect& rect = block.rect;
  if (block.width != width_ || rect.row_begin > rect.row_end || rect.row_end > height_ ||
      block.pixels.size() != std::size_t{rect.rows()} * width_) {
    throw std::logic_error("block does not fit the image");
  }
  for (std::uint32_t i = 0; i < rect.rows(); ++i) {
    const std::size_t row = std::size_t{row_at_[rect.row_begin + i]} * width_;
    const PixelSums* from = block.pixels.data() + std::size_t{i} * width_;
    for (std::uint32_t x = 0; x < width_; ++x) {
      pixels_[row + x] += from[x];
      samples_[row + x] +=
          pass_.empty() ? rect.samples() : common_of(pass_[row + x], rect.sample_range()).count();
    }
  }
  for (const ExcludedSamples& some : block.excluded) {
    const PixelAddress pixel{row_at_.at(some.position), some.x};
    const auto [at, fresh] = excluded_.try_emplace(pixel, Excluded{some.first, 0});
    at->second.first = std::min(at->second.first, some.first);
    at->second.count += some.count;
  }
  counts_ += block.counts;
}

}  // namespace parray
