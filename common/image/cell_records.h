#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/pixel_sums.h"

namespace parray::image {

/// The first part of the record of a traced cell (common/schedule/cell_grid.h). The sums of the
/// cell's pixels follow. TraceCounts explains the first three fields.
struct CellHeader {
  std::uint64_t rays = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t lost = 0;
  /// Time that a thread took to trace the cell. Only this field may differ between two results of
  /// the same cell.
  std::uint64_t nanoseconds = 0;

  friend bool operator==(const CellHeader&, const CellHeader&) = default;
};

/// Returns the bytes of a record, which has room for `cell_pixels` sums. The last cell of a row may
/// have fewer pixels; the remaining bytes are zeros.
inline std::size_t record_bytes(std::uint32_t cell_pixels) {
  return sizeof(CellHeader) + std::size_t{cell_pixels} * sizeof(PixelSums);
}

/// Samples of one pixel that are missing from its sums, because they were NaN or infinite.
struct ExcludedSamples {
  std::uint32_t y = 0;      ///< row of the image
  std::uint32_t x = 0;      ///< column
  std::uint32_t first = 0;  ///< number of the first excluded sample
  std::uint32_t count = 0;  ///< excluded samples, > 0; they need not be consecutive

  friend auto operator<=>(const ExcludedSamples&, const ExcludedSamples&) = default;
};

/// Returns the digest (XXH3) of a record, never 0. Records that differ at most in `nanoseconds`
/// have equal digests.
std::uint64_t cell_digest(std::span<const std::byte> record);
/// Returns the digests of consecutive records of `record_bytes` bytes each.
std::vector<std::uint64_t> cell_digests(std::span<const std::byte> records,
                                        std::size_t record_bytes);
/// Returns the digest of a range of cells from the digests of its cells, in order.
std::uint64_t range_digest(std::span<const std::uint64_t> cell_digests);

/// Copies the header out of a record, which need not be aligned.
CellHeader header_of(std::span<const std::byte> record);
/// Copies the first sums out of a record, as many as `sums` has elements.
void copy_sums(std::span<const std::byte> record, std::span<PixelSums> sums);

}  // namespace parray::image
