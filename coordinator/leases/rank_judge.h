#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "coordinator/jobs/job_picture.h"

namespace parray::coordinator {

/// A rank of one mpirun, as rows and the judge name it.
struct RankVoice {
  TracerKey tracer = 0;       ///< of this rank alone, the same in every mpirun with this host
  std::uint32_t machine = 0;  ///< ranks with the same number are one machine
};

/// Of ranks on these hosts, by rank. The ranks of a host are one machine, except on rank 0's host:
/// rank 0 decides disputes, so there each rank counts by itself.
std::vector<RankVoice> rank_voices(const std::vector<std::string>& hosts);

/// Rank 0's rule where two ranks return different bits for the same samples: rank 0 traces them
/// again, and whoever had other bits is faulty. There is no vote. What a faulty machine traced is
/// traced again, and rank 0 traces again what that machine alone confirmed.
///
/// It lasts for all passes of a job. Plain state; one thread at a time.
class RankJudge {
 public:
  /// A rank that returned wrong bits.
  struct Verdict {
    std::optional<std::uint32_t> rank;    ///< none: it traced in an earlier mpirun
    std::vector<std::uint32_t> left_out;  ///< all ranks of its machine, itself included
    std::uint64_t cells = 0;              ///< that are traced again
    bool restarted = false;               ///< the picture was begun again
  };
  struct Hooks {
    /// Traces a cell in rank 0. Null: there are no disputes, what came first stays.
    std::function<TracedCells(const CellBatch& cell)> trace{};
    /// Gets cells that were set back.
    std::function<void(const std::vector<CellRange>& cells)> retracted{};
    /// The picture, which has passes, was begun again.
    std::function<void()> restarted{};
    std::function<void(const Verdict& verdict)> decided{};
  };
  /// `picture` outlives the judge.
  RankJudge(JobPicture& picture, std::vector<RankVoice> ranks, Hooks hooks);

  [[nodiscard]] std::uint32_t ranks() const { return static_cast<std::uint32_t>(ranks_.size()); }
  [[nodiscard]] TracerKey tracer(std::uint32_t rank) const { return ranks_[rank].tracer; }
  /// Nothing more is taken from this rank.
  [[nodiscard]] bool left_out(std::uint32_t rank) const { return left_out_.contains(rank); }
  [[nodiscard]] const std::vector<Verdict>& verdicts() const { return verdicts_; }
  /// Rank 0 contradicted itself, so that it cannot decide anything. Its cells are set back.
  [[nodiscard]] bool self_doubt() const { return self_doubt_; }

  /// Whether a result of `rank` for the pass under way may be merged. Decides where it differs from
  /// what is in; afterwards nothing that is in differs from it. False: the rank is faulty, or rank
  /// 0 is, or the picture was begun again.
  bool admit(std::uint32_t rank, const TracedCells& traced,
             const std::vector<std::uint64_t>& digests);
  /// Notes that `rank` returned the merged bits of these cells, which other ranks had traced
  /// before.
  void note_checks(std::uint32_t rank, const std::vector<CellRange>& were_in);

  /// Rank 0 has cells to trace again, which a faulty rank alone had confirmed.
  [[nodiscard]] bool has_rechecks() const { return !rechecks_.empty(); }
  /// Traces at most so many of them.
  void recheck(std::uint64_t most_cells);

 private:
  void settle(std::uint32_t rank, std::uint64_t cell, std::uint64_t claim);
  [[nodiscard]] std::uint64_t truth_of(std::uint64_t cell) const;
  void find_faulty(TracerKey tracer);
  void retract(TracerKey tracer, Verdict& verdict);
  [[nodiscard]] std::optional<std::uint32_t> rank_of(TracerKey tracer) const;

  JobPicture& picture_;
  const std::vector<RankVoice> ranks_;
  const Hooks hooks_;
  std::set<std::uint32_t> left_out_;
  std::vector<Verdict> verdicts_;
  std::deque<CellRange> rechecks_;
  bool self_doubt_ = false;
};

}  // namespace parray::coordinator
