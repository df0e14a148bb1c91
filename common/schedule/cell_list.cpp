#include "common/schedule/cell_list.h"

#include <algorithm>

namespace parray::schedule {

CellList::CellList(std::vector<CellRange> ranges) : ranges_(std::move(ranges)), first_{0} {
  for (const CellRange& range : ranges_) first_.push_back(first_.back() + range.count());
}

std::vector<CellRange> CellList::cells_at(const CellRange& places) const {
  std::vector<CellRange> cells;
  std::uint64_t place = places.begin;
  auto at = static_cast<std::size_t>(std::ranges::upper_bound(first_, place) - first_.begin() - 1);
  for (; place < places.end; place = first_[at]) {
    const std::uint64_t begin = ranges_[at].begin + (place - first_[at]);
    cells.push_back({begin, std::min(begin + (places.end - place), ranges_[at].end)});
    ++at;
  }
  return cells;
}

}  // namespace parray::schedule
