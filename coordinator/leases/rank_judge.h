#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/jobs/job_picture.h"

namespace parray::coordinator {

/// The identity of a rank (a process of one mpirun) as a tracer of cells.
struct RankVoice {
  TracerKey tracer = 0;       ///< depends only on the number of the rank and on its host
  std::uint32_t machine = 0;  ///< ranks with the same number are one machine
};

/// Returns the identity of each rank. `hosts`: the host name of each rank, from rank 0 on. All
/// ranks of a host are one machine. But on the host of rank 0 each rank is a machine of its own, so
/// that a fault of another rank there does not exclude rank 0, which decides disputes.
std::vector<RankVoice> rank_voices(const std::vector<std::string>& hosts);

/// Decides which rank is faulty if two ranks return different bits for the same samples. Rank 0
/// traces the samples again, and every rank whose bits differ from those of rank 0 is faulty. There
/// is no vote. The cells of a faulty machine are retracted, and other ranks trace them again. Rank
/// 0 itself traces the cells that only the faulty machine had checked.
///
/// One object serves all passes of a job. Not thread-safe.
class RankJudge {
 public:
  /// A finding: a rank returned wrong bits.
  struct Verdict {
    /// The faulty rank; none: it was part of an earlier mpirun.
    std::optional<std::uint32_t> rank;
    std::vector<std::uint32_t> left_out;  ///< all ranks of its machine: they are excluded now
    std::uint64_t cells = 0;              ///< cells that are traced again; 0 after a restart
    bool restarted = false;               ///< the picture began again from its first pass
  };
  struct Hooks {
    /// Traces a cell in rank 0. Null: no disputes are decided, the first bits stay, and admit()
    /// always returns true.
    std::function<TracedCells(const CellBatch& cell)> trace{};
    /// Called with cells that were retracted.
    std::function<void(const std::vector<CellRange>& cells)> retracted{};
    /// Called when a picture in passes has restarted.
    std::function<void()> restarted{};
    /// Called after each finding.
    std::function<void(const Verdict& verdict)> decided{};
  };
  /// `picture` must outlive this object.
  RankJudge(JobPicture& picture, std::vector<RankVoice> ranks, Hooks hooks);

  [[nodiscard]] std::uint32_t ranks() const { return static_cast<std::uint32_t>(ranks_.size()); }
  [[nodiscard]] TracerKey tracer(std::uint32_t rank) const { return ranks_[rank].tracer; }
  /// Returns whether a rank is excluded: its results are dropped.
  [[nodiscard]] bool left_out(std::uint32_t rank) const { return left_out_.contains(rank); }
  [[nodiscard]] const std::vector<Verdict>& verdicts() const { return verdicts_; }
  /// Returns whether rank 0 was found faulty by its own second tracing of a cell. Then rank 0
  /// decides no more disputes, its cells are retracted, and admit() returns false.
  [[nodiscard]] bool self_doubt() const { return self_doubt_; }

  /// Returns whether a result of `rank` for the current pass may be merged. `digests`: from
  /// ResultCollector::digests_of(). If the result differs from merged cells, first decides who
  /// is wrong and retracts the wrong merged cells, so that no merged cell differs afterwards.
  /// False: `rank` or rank 0 is faulty, or the picture has restarted.
  bool admit(std::uint32_t rank, const TracedCells& traced,
             const std::vector<std::uint64_t>& digests);
  /// Notes that `rank` returned the merged bits of the cells `were_in`, which other ranks had
  /// traced first.
  void note_checks(std::uint32_t rank, const std::vector<CellRange>& were_in);

  /// Returns whether rank 0 must trace cells again that only a faulty rank had checked.
  [[nodiscard]] bool has_rechecks() const { return !rechecks_.empty(); }
  /// Traces at most `most_cells` of these cells in rank 0 and compares them, until self_doubt().
  void recheck(std::uint64_t most_cells);

 private:
  void compare_with_rank_0(std::uint32_t rank, std::uint64_t cell, std::uint64_t claim);
  [[nodiscard]] std::uint64_t digest_by_rank_0(std::uint64_t cell) const;
  void find_faulty(TracerKey tracer);
  void retract(TracerKey tracer, Verdict& verdict);

  JobPicture& picture_;
  const std::vector<RankVoice> ranks_;
  const Hooks hooks_;
  std::set<std::uint32_t> left_out_;
  std::vector<Verdict> verdicts_;
  std::deque<CellRange> rechecks_;
  bool self_doubt_ = false;
};

}  // namespace parray::coordinator
