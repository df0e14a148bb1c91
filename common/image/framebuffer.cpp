#include "common/image/framebuffer.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace parray::image {

Framebuffer::Framebuffer(std::uint32_t width, std::uint32_t height, bool large_pages)
    : width_(width),
      height_(height),
      pixels_(std::size_t{width} * height, large_pages),
      samples_(pixels_.size()),
      untouched_(pixels_.size()) {}

void Framebuffer::add(std::uint32_t y, std::uint32_t x, std::span<const PixelSums> sums,
                      const RunSamples& samples, std::uint32_t step) {
  if (y >= height_ || x > width_ || sums.size() > (width_ - x + step - 1) / step) {
    throw std::logic_error("sums of pixels outside the picture");
  }
  std::size_t pixel = std::size_t{y} * width_ + x;
  for (std::size_t i = 0; i < sums.size(); ++i, pixel += step) {
    pixels_[pixel] += sums[i];
    const std::uint32_t before = samples_[pixel];
    const std::uint32_t more = samples[i].count();
    samples_[pixel] = before + more;
    untouched_ -= before == 0 && more > 0 ? 1 : 0;
  }
}

void Framebuffer::expect(std::uint32_t y, std::uint32_t x) const {
  constexpr std::size_t line = 64;
  // Four pixels; the processor prefetches the following ones itself.
  constexpr std::size_t fetched = 5 * line;
  const std::size_t pixel = std::size_t{y} * width_ + x;
  const auto* const sums = reinterpret_cast<const std::byte*>(&pixels()[pixel]);
  for (std::size_t at = 0; at < fetched; at += line) __builtin_prefetch(sums + at, 1);
  __builtin_prefetch(&samples()[pixel], 1);
}

void Framebuffer::touch(std::size_t part, std::size_t parts) {
  const std::span<std::byte> memory =
      std::as_writable_bytes(std::span(&pixels_[0], pixels_.size()));
  constexpr std::size_t page = 4096;
  const std::size_t end = memory.size() * (part + 1) / parts;
  for (std::size_t at = memory.size() * part / parts; at < end; at += page) {
    volatile std::byte& byte = memory[at];
    byte = byte;
  }
}

void Framebuffer::exclude(const ExcludedSamples& samples) {
  if (samples.y >= height_ || samples.x >= width_) {
    throw std::logic_error("samples of pixels outside the picture");
  }
  const auto [at, fresh] =
      excluded_.try_emplace(PixelAddress{samples.y, samples.x}, Excluded{samples.first, 0});
  at->second.first = std::min(at->second.first, samples.first);
  at->second.count += samples.count;
}

void Framebuffer::clear(std::uint32_t y, std::uint32_t x_begin, std::uint32_t x_end,
                        const TraceCounts& counts, std::uint32_t step) {
  for (std::uint32_t x = x_begin; x < x_end; x += step) {
    const std::size_t pixel = std::size_t{y} * width_ + x;
    untouched_ += samples_[pixel] > 0 ? 1 : 0;
    samples_[pixel] = 0;
    pixels_[pixel] = {};
    excluded_.erase({y, x});
  }
  counts_ -= counts;
}

}  // namespace parray::image
