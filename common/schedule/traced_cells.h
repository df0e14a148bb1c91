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
  /// The samples that the headers of the records count as `nonfinite`: sorted by y, x and first, at
  /// most one entry per pixel and cell.
  std::vector<ExcludedSamples> excluded;
  std::uint64_t samples = 0;  ///< of all cells, including excluded ones
  double seconds = 0;         ///< from the start until the last thread has ended: elapsed time

  friend bool operator==(const TracedCells&, const TracedCells&) = default;
};

/// Returns the form in which results are sent and stored. Each cell has `rays`, `nonfinite` and
/// `lost` of its CellHeader (u64 each) and its sums in as few bits as they need (packed_sums.h).
/// Then follow, up to the end, the excluded samples: y, x, first, count (u32 each). Numbers are
/// little-endian. Equal counts and sums give equal bytes; times are left out. `grid` must be that
/// of the cells.
std::string pack_cells(const TracedCells& traced, const CellGrid& grid);

/// Unpacks the output of pack_cells() for the cells of `batch`. `samples` becomes
/// batch.sample_count(), and all times become 0, also those in the records. Throws DecodeError for
/// bytes that pack_cells() does not return, and for numbers that tracing these samples cannot give.
/// Examples are sums above the bound of their samples, and more rays than paths of `max_depth`
/// segments have. `max_depth` is the setting of the picture. Excluded samples must belong to
/// pixels of `batch`, be as many in each cell as its `nonfinite` says, and be in order.
TracedCells unpack_cells(std::string_view bytes, const CellBatch& batch, std::uint32_t max_depth);

/// Makes the checks of unpack_cells() for cells that were not packed, such as those of an MPI rank.
/// Returns a phrase for messages that says what is wrong, or "" if all checks pass.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::uint32_t max_depth);
/// Returns fault_of(traced, batch, max_depth), faster. `cells` must be the cells of `batch`.
std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::span<const Cell> cells,
                     std::uint32_t max_depth);

}  // namespace parray::schedule
