#pragma once

#include <algorithm>
#include <cstdint>

namespace parray {

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

}  // namespace parray
