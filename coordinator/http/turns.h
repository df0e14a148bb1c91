#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/rooms.h"

namespace parray::http {

/// A queue of items with owner names. The next item belongs to the name that has the fewest items
/// in progress and, among names with equally many, had its last turn longest ago. A name that has
/// no items left is forgotten: when it returns, it precedes names that had a turn. Not thread-safe.
template <typename Item>
class Turns {
 public:
  /// `most_of_one`: limit of items of one name that are in progress, >= 1.
  explicit Turns(std::size_t most_of_one) : most_of_one_(most_of_one) {}

  /// Adds an item to the queue of `name`.
  void push(const std::string& name, Item item) {
    lines_[name].waiting.push_back(std::move(item));
    ++waiting_;
  }

  /// Returns the next item, which is in progress until ended(). Returns nothing if no item waits or
  /// may begin.
  std::optional<Item> take() {
    Line* next = nullptr;
    for (auto& [name, line] : lines_) {
      const bool may = !line.waiting.empty() && line.under_way < most_of_one_;
      if (may && (next == nullptr || line.before(*next))) next = &line;
    }
    if (next == nullptr) return std::nullopt;
    Item item = std::move(next->waiting.front());
    next->waiting.pop_front();
    ++next->under_way;
    next->last_turn = ++turns_;
    --waiting_;
    return item;
  }

  /// Records that an item of `name` from take() is no longer in progress.
  void ended(const std::string& name) {
    const auto line = lines_.find(name);
    --line->second.under_way;
    if (line->second.under_way == 0 && line->second.waiting.empty()) lines_.erase(line);
  }

  /// Returns the number of waiting items of all names.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }

 private:
  struct Line {
    std::deque<Item> waiting;
    std::size_t under_way = 0;
    std::uint64_t last_turn = 0;

    [[nodiscard]] bool before(const Line& other) const {
      return std::pair(under_way, last_turn) < std::pair(other.under_way, other.last_turn);
    }
  };

  std::size_t most_of_one_;
  std::map<std::string, Line> lines_;
  std::size_t waiting_ = 0;
  std::uint64_t turns_ = 0;
};

}  // namespace parray::http
