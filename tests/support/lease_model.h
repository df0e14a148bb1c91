#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "coordinator/lease_table.h"

namespace parray::test {

/// What PROTOCOL.md says, written down as slowly and plainly as possible.
class LeaseModel {
 public:
  enum class Cell : std::uint8_t { pending, leased, done };
  enum class State : std::uint8_t { leased, retired, done };

  struct Record {
    WorkRect rect;
    std::map<WorkerId, Time> holders;
    State state = State::leased;
    ResultDigest digest = 0;
  };

  LeaseModel(std::uint32_t height, std::uint32_t spp)
      : spp_(spp), cells_(std::size_t{height} * spp), merged_(cells_.size()) {}

  /// Every sample of `rect` goes from one state to another; false if one was in a third.
  bool move(const WorkRect& rect, Cell from, Cell to) {
    bool good = true;
    for_each(rect, [&](std::size_t i) {
      good = good && cells_[i] == from;
      cells_[i] = to;
      merged_[i] += to == Cell::done ? 1U : 0U;
    });
    return good;
  }

  [[nodiscard]] std::uint64_t count(Cell state) const {
    return static_cast<std::uint64_t>(std::count(cells_.begin(), cells_.end(), state));
  }
  [[nodiscard]] bool each_merged_once() const {
    return std::all_of(merged_.begin(), merged_.end(), [](std::uint32_t n) { return n == 1; });
  }

  void retire_if_unheld(Record& record, bool& good) {
    if (record.state == State::leased && record.holders.empty()) {
      record.state = State::retired;
      good = move(record.rect, Cell::leased, Cell::pending) && good;
    }
  }

  std::map<Epoch, Record> records;  ///< every epoch ever granted in this life of the table

 private:
  template <typename Function>
  void for_each(const WorkRect& rect, Function function) {
    for (std::uint32_t row = rect.row_begin; row < rect.row_end; ++row) {
      for (std::uint32_t s = rect.sample_begin; s < rect.sample_end; ++s) {
        function(std::size_t{row} * spp_ + s);
      }
    }
  }

  std::uint32_t spp_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> merged_;
};

}  // namespace parray::test
