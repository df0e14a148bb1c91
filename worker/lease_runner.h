#pragma once

#include <optional>

#include "proto/clock.h"
#include "worker/lease_source.h"
#include "worker/team.h"

namespace parray::worker {

/// Keeps a team at work: takes leases from a source and hands in their results.
///
/// The runner takes the next lease just before the team runs out of work, so that the team need not
/// wait. For this it needs the samples of the current lease and the speed of the team. Without them
/// it takes the next lease when the team is done. It holds at most one lease besides the current
/// one.
class LeaseRunner {
 public:
  /// The references must outlive the object. `clock` measures the time within one tick(). `before`
  /// is the work that the team did for earlier sources.
  LeaseRunner(LeaseSource& source, Team& team, const Clock& clock, WorkTally before = {});

  /// Does the work that is due. Returns the latest time of the next call. Call it sooner when the
  /// team is done or something has arrived.
  Time tick(Time now);

  /// Returns whether the team traces nothing and no lease waits.
  [[nodiscard]] bool idle() const { return !next_ && !tracing_; }
  /// Returns whether no more work will follow.
  [[nodiscard]] bool over() const { return over_; }
  /// Gives up all leases and reports tally() to the source.
  void stop();
  /// Returns all work of the team, including `before`.
  [[nodiscard]] const WorkTally& tally() const { return tally_; }

 private:
  void drop_unwanted();
  void hand_in();
  void keep_at_work(Time now, bool copies);
  void take(Time now, bool idle);
  void start_next(Time now);
  void note(const LeaseResult& finished);

  LeaseSource& source_;
  Team& team_;
  const Clock& clock_;
  std::optional<LeaseSource::Taken> next_;  ///< not started
  std::optional<LeaseKey> tracing_;
  bool over_ = false;
  double samples_per_second_ = 0;
  Time take_at_{};  ///< when the next lease is due
  Time wait_{};     ///< delay after the answer `wait`
  WorkTally tally_;
};

}  // namespace parray::worker
