#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "common/image/pixel_sums.h"
#include "common/image/sample_range.h"

namespace parray {

/// A rectangle of work: rows at positions [row_begin, row_end) of the job's row order, and of
/// every pixel in them the samples [sample_begin, sample_end); in a pass that gives each pixel a
/// range of its own (Framebuffer::begin_pass), what the pixel has of these.
struct WorkRect {
  std::uint32_t row_begin = 0;
  std::uint32_t row_end = 0;
  std::uint32_t sample_begin = 0;
  std::uint32_t sample_end = 0;

  [[nodiscard]] std::uint32_t rows() const { return row_end - row_begin; }
  [[nodiscard]] std::uint32_t samples() const { return sample_end - sample_begin; }
  [[nodiscard]] SampleRange sample_range() const { return {sample_begin, sample_end}; }
  /// Units of ChunkRequest.
  [[nodiscard]] std::uint64_t units() const { return std::uint64_t{rows()} * samples(); }
  friend bool operator==(const WorkRect&, const WorkRect&) = default;
};

/// Samples of one pixel that are not in its sums, because they were NaN or infinite.
struct ExcludedSamples {
  std::uint32_t position = 0;  ///< of the row in the job's row order
  std::uint32_t x = 0;
  std::uint32_t first = 0;  ///< the first such sample
  std::uint32_t count = 0;  ///< > 0

  friend auto operator<=>(const ExcludedSamples&, const ExcludedSamples&) = default;
};

/// The finished sums of one rectangle of work.
struct RowBlock {
  WorkRect rect;
  std::uint32_t width = 0;
  TraceCounts counts;
  std::vector<PixelSums> pixels;  ///< rect.rows() * width, in position order
  /// Where counts.nonfinite comes from: at most one entry a pixel and piece of work.
  std::vector<ExcludedSamples> excluded{};

  friend bool operator==(const RowBlock&, const RowBlock&) = default;
};

}  // namespace parray
