#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/cell_records.h"
#include "common/schedule/cell_grid.h"

namespace parray::schedule {

/// What has come of tracing some cells.
struct TracedCells {
  CellRange range;
  /// Of each cell, one after the other, record_bytes(cell_pixels): see cell_records.h.
  std::vector<std::byte> records;
  /// Where the headers' `nonfinite` come from: sorted, at most one entry a pixel and cell.
  std::vector<ExcludedSamples> excluded;
  std::uint64_t samples = 0;
  double seconds = 0;  ///< spent tracing

  friend bool operator==(const TracedCells&, const TracedCells&) = default;
};

/// As it travels and is kept: of each cell rays, non-finite samples and lost throughput (u64 each)
/// and its sums in as few bits as they need (packed_sums.h), then the excluded samples (4 times u32
/// each). Equal counts and sums have equal bytes; times are left out.
std::string pack_cells(const TracedCells& traced, const CellGrid& grid);

/// Inverse of pack_cells() for cells of `batch`; `samples` is the batch's, seconds are 0. Throws
/// DecodeError for anything else, and for numbers that tracing these samples cannot have given:
/// sums above their samples' bound, more rays than `max_depth` a sample, other excluded samples
/// than each cell's pixels have and its count says, or those in another order.
TracedCells unpack_cells(std::string_view bytes, const CellBatch& batch, std::uint32_t max_depth);

/// The same checks of cells that have come another way. Empty: nothing is wrong.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::uint32_t max_depth);
/// The same with the batch's cells at hand.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::span<const Cell> cells,
                     std::uint32_t max_depth);

}  // namespace parray::schedule
