#pragma once

#include <cstdint>
#include <vector>

#include "common/schedule/cell_grid.h"

namespace parray::schedule {

/// A list of some cells of a plan in ascending order. The place of a cell is its position in the
/// list, from 0. Immutable and thread-safe.
class CellList {
 public:
  CellList() = default;
  /// `ranges` must be ascending and disjoint, and no range may be empty.
  explicit CellList(std::vector<CellRange> ranges);

  /// Returns the number of cells in the list.
  [[nodiscard]] std::uint64_t count() const { return first_.empty() ? 0 : first_.back(); }
  [[nodiscard]] const std::vector<CellRange>& ranges() const { return ranges_; }
  /// Returns the cells at `places` [begin, end) of the list, with end <= count(), as ascending
  /// ranges: one for each element of ranges() that they touch.
  [[nodiscard]] std::vector<CellRange> cells_at(const CellRange& places) const;

 private:
  std::vector<CellRange> ranges_;
  std::vector<std::uint64_t> first_;  ///< place of the first cell of each range, and the total
};

}  // namespace parray::schedule
