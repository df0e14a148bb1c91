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

/// The result of tracing some cells.
struct TracedCells {
  CellRange range;
  /// One record per cell, each of record_bytes(cell_pixels) bytes: see cell_records.h.
  std::vector<std::byte> records;
  /// The samples that the headers of the records count as `nonfinite`: sorted, at most one entry
  /// per pixel and cell.
  std::vector<ExcludedSamples> excluded;
  std::uint64_t samples = 0;
  double seconds = 0;  ///< spent tracing

  friend bool operator==(const TracedCells&, const TracedCells&) = default;
};

/// Returns the form in which results are sent and stored. Each cell has its rays, non-finite
/// samples and lost throughput (u64 each) and its sums in as few bits as they need (packed_sums.h).
/// Then follow the excluded samples (4 times u32 each). Equal counts and sums give equal bytes;
/// times are left out.
std::string pack_cells(const TracedCells& traced, const CellGrid& grid);

/// Unpacks the output of pack_cells() for the cells of `batch`. `samples` becomes the batch's
/// number, `seconds` 0. Throws DecodeError for any other bytes, and for numbers that tracing these
/// samples cannot give. Examples are sums above the bound of their samples, and more rays
/// per sample than `max_depth`. Excluded samples must belong to the cell's pixels, agree with its
/// count, and be in order.
TracedCells unpack_cells(std::string_view bytes, const CellBatch& batch, std::uint32_t max_depth);

/// Makes the checks of unpack_cells() for cells that were not packed, such as those of an MPI rank.
/// Returns what is wrong; empty: nothing is.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::uint32_t max_depth);
/// Does the same with the cells of the batch, which the caller already has.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::span<const Cell> cells,
                     std::uint32_t max_depth);

}  // namespace parray::schedule
