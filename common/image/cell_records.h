#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/pixel_sums.h"

namespace parray::image {

/// The first part of a cell's record; the sums of its pixels follow.
struct CellHeader {
  std::uint64_t rays = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t lost = 0;
  /// Tracing time: the only field in which copies of a result differ.
  std::uint64_t nanoseconds = 0;

  friend bool operator==(const CellHeader&, const CellHeader&) = default;
};

/// Returns the bytes of a record. The last cell of a row may leave some of them unused; these are
/// zeros.
inline std::size_t record_bytes(std::uint32_t cell_pixels) {
  return sizeof(CellHeader) + std::size_t{cell_pixels} * sizeof(PixelSums);
}

/// Samples of one pixel that are missing from its sums, because they were NaN or infinite.
struct ExcludedSamples {
  std::uint32_t y = 0;  ///< row of the image
  std::uint32_t x = 0;
  std::uint32_t first = 0;  ///< number of the first excluded sample
  std::uint32_t count = 0;  ///< excluded samples, > 0; they need not be consecutive

  friend auto operator<=>(const ExcludedSamples&, const ExcludedSamples&) = default;
};

/// Returns the digest of a record, never 0. Records that differ at most in `nanoseconds` have equal
/// digests.
std::uint64_t cell_digest(std::span<const std::byte> record);
/// Returns the digests of consecutive records of `record_bytes` bytes each.
std::vector<std::uint64_t> cell_digests(std::span<const std::byte> records,
                                        std::size_t record_bytes);
/// Returns the digest of a range from the digests of its cells.
std::uint64_t range_digest(std::span<const std::uint64_t> cell_digests);

/// Copies the header out of a record, which need not be aligned.
CellHeader header_of(std::span<const std::byte> record);
/// Copies as many sums as `sums` has elements out of a record.
void copy_sums(std::span<const std::byte> record, std::span<PixelSums> sums);

}  // namespace parray::image
