#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/rooms.h"

namespace parray::image {

/// Half-open range of sample indices of a pixel.
struct SampleRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  [[nodiscard]] std::uint32_t count() const { return end - begin; }
  friend bool operator==(const SampleRange&, const SampleRange&) = default;
};

/// What both have; empty where they are apart.
inline SampleRange common_of(const SampleRange& a, const SampleRange& b) {
  const std::uint32_t begin = std::max(a.begin, b.begin);
  return {begin, std::max(begin, std::min(a.end, b.end))};
}

/// Samples of each pixel of a run: the same of all, or a range of its own for each. A view.
class RunSamples {
 public:
  explicit RunSamples(const SampleRange& all) : all_(all) {}
  /// A range for each pixel, which may be empty; `each` outlives the view.
  explicit RunSamples(std::span<const SampleRange> each) : each_(each) {}

  /// Of the pixel `index` pixels right of the run's first.
  [[nodiscard]] SampleRange operator[](std::size_t index) const {
    return each_.empty() ? all_ : each_[index];
  }

 private:
  SampleRange all_;
  std::span<const SampleRange> each_;
};

}  // namespace parray::image
