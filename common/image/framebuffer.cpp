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
      row_samples_(settings.height) {}

void Framebuffer::merge(const RowBlock& block) {
  const WorkRect& rect = block.rect;
  if (block.width != width_ || rect.row_begin > rect.row_end || rect.row_end > height_ ||
      block.pixels.size() != std::size_t{rect.rows()} * width_) {
    throw std::logic_error("block does not fit the image");
  }
  for (std::uint32_t i = 0; i < rect.rows(); ++i) {
    const std::uint32_t row = row_at_[rect.row_begin + i];
    const PixelSums* from = block.pixels.data() + std::size_t{i} * width_;
    PixelSums* to = pixels_.data() + std::size_t{row} * width_;
    for (std::uint32_t x = 0; x < width_; ++x) {
      to[x] += from[x];
    }
    row_samples_[row] += rect.samples();
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
