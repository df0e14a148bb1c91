#pragma once

#include <cstdint>
#include <vector>

#include "common/image/pixel_sums.h"

namespace parray {

/// A rectangle of work: rows at positions [row_begin, row_end) of the job's row order, and of
/// every pixel in them the samples [sample_begin, sample_end).
struct WorkRect {
  std::uint32_t row_begin = 0;
  std::uint32_t row_end = 0;
  std::uint32_t sample_begin = 0;
  std::uint32_t sample_end = 0;

  [[nodiscard]] std::uint32_t rows() const { return row_end - row_begin; }
  [[nodiscard]] std::uint32_t samples() const { return sample_end - sample_begin; }
  /// Units of ChunkRequest.
  [[nodiscard]] std::uint64_t units() const { return std::uint64_t{rows()} * samples(); }
  friend bool operator==(const WorkRect&, const WorkRect&) = default;
};

/// The finished sums of one rectangle of work.
struct RowBlock {
  WorkRect rect;
  std::uint32_t width = 0;
  TraceCounts counts;
  std::vector<PixelSums> pixels;  ///< rect.rows() * width, in position order

  friend bool operator==(const RowBlock&, const RowBlock&) = default;
};

}  // namespace parray
