#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/rooms.h"

namespace parray::image {

/// The samples of a pixel with numbers begin .. end - 1.
struct SampleRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  [[nodiscard]] std::uint32_t count() const { return end - begin; }
  friend bool operator==(const SampleRange&, const SampleRange&) = default;
};

/// Returns the intersection of both ranges; empty if they are disjoint.
inline SampleRange common_of(const SampleRange& a, const SampleRange& b) {
  const std::uint32_t begin = std::max(a.begin, b.begin);
  return {begin, std::max(begin, std::min(a.end, b.end))};
}

/// The samples of each pixel of a run (pixels of one row): one range for all pixels, or one range
/// per pixel. A view.
class RunSamples {
 public:
  explicit RunSamples(const SampleRange& all) : all_(all) {}
  /// Takes one range per pixel, which may be empty; `each` must outlive the view.
  explicit RunSamples(std::span<const SampleRange> each) : each_(each) {}

  /// Returns the range of pixel number `index` of the run, from the left.
  [[nodiscard]] SampleRange operator[](std::size_t index) const {
    return each_.empty() ? all_ : each_[index];
  }

 private:
  SampleRange all_;
  std::span<const SampleRange> each_;
};

}  // namespace parray::image
