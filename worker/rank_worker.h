#pragma once

#include <cstdint>
#include <deque>

#include "common/schedule/work_plan.h"
#include "proto/clock.h"
#include "worker/cell_team.h"
#include "worker/lease_source.h"

namespace parray {

/// What a rank has done.
struct RankTally {
  std::uint64_t samples = 0;
  std::uint64_t takes = 0;
  Time taking{};    ///< spent in LeaseSource::take(), where it gave a lease
  Time putting{};   ///< spent in LeaseSource::complete()
  double busy = 0;  ///< seconds of tracing
};

/// A rank's part in a job over a window: keeps its team at work and hands in what is traced.
///
/// Plain state: `now` is an argument. A lease is traced in slices, so that results come in steadily
/// and buffers stay small; the next lease is taken just before the team runs out of work, so that a
/// rank never holds much more than it is working on.
class RankWorker {
 public:
  /// References outlive the worker. `before`: what the rank has done in earlier passes of the job.
  RankWorker(const WorkPlan& plan, LeaseSource& leases, CellTeam& team, const Clock& clock,
             const RankTally& before = {});

  /// Does what is due. Returns when it wants to be called again, at the latest; sooner when the
  /// team is done.
  Time tick(Time now);

  /// Nothing will be left to do: every cell of the job is in.
  [[nodiscard]] bool over() const { return over_; }
  /// Gives up what it is tracing: somebody has the same cells already.
  void stop();
  /// Says how much it has done.
  void report();

  using Tally = RankTally;
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  void keep_at_work(Time now);
  void hand_in();
  void take(Time now);
  void start_next(Time now);
  void beat(Time now);
  [[nodiscard]] double samples_of(const CellRange& range) const;

  const WorkPlan& plan_;
  LeaseSource& leases_;
  CellTeam& team_;
  const Clock& clock_;
  std::deque<CellRange> slices_;  ///< of leases, not started
  bool tracing_ = false;
  bool over_ = false;
  double samples_per_second_ = 0;
  Time take_at_{};  ///< when the next lease is due
  Time wait_{};     ///< how long to wait after being told to
  Time next_beat_{};
  RankTally tally_;
};

}  // namespace parray
