#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/pixel_sums.h"

namespace parray::image {

/// What a cell's record begins with; the sums of its pixels follow.
struct CellHeader {
  std::uint64_t rays = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t lost = 0;
  std::uint64_t nanoseconds = 0;  ///< spent tracing: the one thing that differs between copies

  friend bool operator==(const CellHeader&, const CellHeader&) = default;
};

/// Bytes of a record; the last cell of a row may leave some of them unused, as zeros.
inline std::size_t record_bytes(std::uint32_t cell_pixels) {
  return sizeof(CellHeader) + std::size_t{cell_pixels} * sizeof(PixelSums);
}

/// Samples of one pixel that are not in its sums, because they were NaN or infinite.
struct ExcludedSamples {
  std::uint32_t y = 0;  ///< row of the image
  std::uint32_t x = 0;
  std::uint32_t first = 0;  ///< the first such sample
  std::uint32_t count = 0;  ///< > 0

  friend auto operator<=>(const ExcludedSamples&, const ExcludedSamples&) = default;
};

/// Digest of a record, never 0: equal unless counts or sums differ; `nanoseconds` does not count.
std::uint64_t cell_digest(std::span<const std::byte> record);
/// Digests of consecutive records.
std::vector<std::uint64_t> cell_digests(std::span<const std::byte> records,
                                        std::size_t record_bytes);
/// Digest of a range, from those of its cells.
std::uint64_t range_digest(std::span<const std::uint64_t> cell_digests);

/// Copied out of a record: it need not be aligned.
CellHeader header_of(std::span<const std::byte> record);
/// `sums` has the number of pixels wanted.
void copy_sums(std::span<const std::byte> record, std::span<PixelSums> sums);

}  // namespace parray::image
