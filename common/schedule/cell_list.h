#pragma once

#include <cstdint>
#include <vector>

#include "common/schedule/cell_grid.h"

namespace parray::schedule {

/// Some cells of a plan, counted through from 0. Immutable; any thread.
class CellList {
 public:
  CellList() = default;
  /// `ranges` ascend, are apart and not empty.
  explicit CellList(std::vector<CellRange> ranges);

  [[nodiscard]] std::uint64_t count() const { return first_.empty() ? 0 : first_.back(); }
  [[nodiscard]] const std::vector<CellRange>& ranges() const { return ranges_; }
  /// The cells whose places in the list are `places`, which lie below count(): as few ranges as
  /// there can be.
  [[nodiscard]] std::vector<CellRange> cells_at(const CellRange& places) const;

 private:
  std::vector<CellRange> ranges_;
  std::vector<std::uint64_t> first_;  ///< place of the first cell of each range, and the total
};

}  // namespace parray::schedule
