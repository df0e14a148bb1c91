#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "common/schedule/cell_grid.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns the seconds that one cell of a batch takes in virtual time.
using CellCost = std::function<double(const CellBatch& batch, std::uint64_t cell)>;

/// Returns the number of samples of one cell of the batch.
inline std::uint64_t samples_of(const CellBatch& batch, std::uint64_t cell) {
  std::uint64_t samples = 0;
  for (const SampleRange& range : batch.column_ranges_of(cell)) samples += range.count();
  return samples;
}

/// Returns the batch's first `cells` cells.
inline CellBatch first_cells(const CellBatch& batch, std::uint64_t cells) {
  CellBatch part{batch.grid, {batch.range.begin, batch.range.begin + cells}, batch.samples};
  if (!part.samples.empty()) part.samples.resize(cells * batch.grid->shape().cell_pixels);
  return part;
}

/// The part of a lease that a worker returns, and the seconds of tracing.
struct TimedCells {
  CellBatch cells;
  double seconds = 0;
};

/// Returns the cells that trace_cells() with one thread would return after `longest` seconds; 0:
/// all.
inline TimedCells cells_within(const CellBatch& batch, double longest, const CellCost& cost) {
  const std::uint64_t piece = batch.grid->shape().piece_cells;
  double seconds = 0;
  std::uint64_t cells = 0;
  while (cells < batch.range.count() && (longest <= 0 || cells == 0 || seconds < longest)) {
    const std::uint64_t end = std::min(cells + piece, batch.range.count());
    for (; cells < end; ++cells) seconds += cost(batch, batch.range.begin + cells);
  }
  return {first_cells(batch, cells), seconds};
}

}  // namespace parray::test
