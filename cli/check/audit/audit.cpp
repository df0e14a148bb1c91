#include "cli/check/audit/audit.h"

#include <iterator>
#include <map>
#include <set>

namespace parray::audit {
namespace {

/// A set of cells, as ranges that do not overlap.
class Coverage {
 public:
  /// Adds a range. Returns false, and changes nothing, if it contains some of the cells already.
  bool add(const CellRange& range) {
    auto next = ranges_.lower_bound(range.begin);
    if ((next != ranges_.end() && next->first < range.end) ||
        (next != ranges_.begin() && std::prev(next)->second > range.begin)) {
      return false;
    }
    ranges_.emplace(range.begin, range.end);
    cells_ += range.count();
    return true;
  }

  /// Removes a range. Returns false if it lacks some of the cells.
  bool remove(const CellRange& range) {
    std::uint64_t removed = 0;
    auto at = ranges_.upper_bound(range.begin);
    at = at == ranges_.begin() ? at : std::prev(at);
    while (at != ranges_.end() && at->first < range.end) {
      const CellRange found{at->first, at->second};
      if (found.end <= range.begin) {
        ++at;
        continue;
      }
      at = ranges_.erase(at);
      if (found.begin < range.begin) ranges_.emplace(found.begin, range.begin);
      if (found.end > range.end) at = ranges_.emplace(range.end, found.end).first;
      removed += std::min(found.end, range.end) - std::max(found.begin, range.begin);
    }
    cells_ -= removed;
    return removed == range.count();
  }

  [[nodiscard]] std::uint64_t cells() const { return cells_; }

 private:
  std::map<std::uint64_t, std::uint64_t> ranges_;  ///< begin, end
  std::uint64_t cells_ = 0;
};

class Auditor {
 public:
  void take(const JournalWorker& e) {
    workers_[e.tracer] = audit_.workers.size();
    audit_.workers.push_back({e.name, e.threads, 0, 0, 0});
  }

  void take(const JournalPass& e) {
    if (passes_.contains(e.pass)) {
      problem("pass " + std::to_string(e.pass) + " begins twice");
      return;
    }
    passes_[e.pass].first = e.cells;
    audit_.cells += e.cells;
    ++audit_.passes;
  }

  void take(const JournalGrid& /*entry*/) {}

  void take(const JournalMerge& e) {
    ++audit_.leases;
    const auto pass = passes_.find(e.pass);
    const auto worker = workers_.find(e.tracer);
    if (pass == passes_.end() || e.range.end > pass->second.first) {
      problem(text(e.pass, e.range) + " belong to a pass that has not begun");
    } else if (worker == workers_.end()) {
      problem(text(e.pass, e.range) + " were merged by an unknown worker");
    } else if (!epochs_.insert(e.epoch).second) {
      problem("a lease of " + text(e.pass, e.range) + " was merged twice");
    } else if (!pass->second.second.add(e.range)) {
      problem(text(e.pass, e.range) + " were merged, but some of them had been merged before");
    } else {
      Audit::Worker& by = audit_.workers[worker->second];
      ++by.leases;
      by.cells += e.range.count();
      by.seconds += e.seconds;
    }
  }

  void take(const JournalRetraction& e) {
    for (const CellRange& range : e.cells) {
      audit_.set_back += range.count();
      if (!passes_[e.pass].second.remove(range)) {
        problem(text(e.pass, range) + " were set back, but not all of them had been merged");
      }
    }
  }

  Audit finish() {
    for (const auto& [number, pass] : passes_) audit_.merged += pass.second.cells();
    return std::move(audit_);
  }

 private:
  static std::string text(std::uint32_t pass, const CellRange& range) {
    return "cells " + std::to_string(range.begin) + " to " + std::to_string(range.end - 1) +
           " of pass " + std::to_string(pass);
  }

  void problem(std::string line) {
    constexpr std::size_t most = 100;
    if (audit_.problems.size() < most) audit_.problems.push_back(std::move(line));
  }

  Audit audit_;
  std::map<TracerKey, std::size_t> workers_;  ///< indices in Audit::workers
  std::map<std::uint32_t, std::pair<std::uint64_t, Coverage>> passes_;  ///< all and merged cells
  std::set<std::uint64_t> epochs_;
};

}  // namespace

Audit audit_journal(const std::vector<JournalEntry>& journal) {
  Auditor auditor;
  for (const JournalEntry& entry : journal) {
    std::visit([&](const auto& e) { auditor.take(e); }, entry);
  }
  return auditor.finish();
}

}  // namespace parray::audit
