#pragma once

#include <optional>

#include "proto/clock.h"
#include "worker/lease_source.h"
#include "worker/team.h"

namespace parray::worker {

/// Keeps a team at work: takes leases from a source and hands in what comes of them.
///
/// Plain state: `now` is an argument. The next lease is taken just before the team runs out of
/// work, so that it never waits, and never holds much more than it is working on.
class LeaseRunner {
 public:
  /// References outlive the object. `before`: what the team has done for earlier sources.
  LeaseRunner(LeaseSource& source, Team& team, const Clock& clock, WorkTally before = {});

  /// Does what is due. Returns when it wants to be called again, at the latest; sooner when the
  /// team is done, or something has arrived.
  Time tick(Time now);

  /// Nothing is being traced, and no lease is at hand.
  [[nodiscard]] bool idle() const { return !next_ && !tracing_; }
  /// Nothing will be left to do.
  [[nodiscard]] bool over() const { return over_; }
  /// Gives up what it holds, and reports to the source what the team has done.
  void stop();
  [[nodiscard]] const WorkTally& tally() const { return tally_; }

 private:
  void drop_unwanted();
  void hand_in();
  void keep_at_work(Time now, bool copies);
  void take(Time now, bool idle);
  void start_next(Time now);
  void note(const Finished& finished);

  LeaseSource& source_;
  Team& team_;
  const Clock& clock_;
  std::optional<LeaseSource::Taken> next_;  ///< not started
  std::optional<LeaseKey> tracing_;
  bool over_ = false;
  double samples_per_second_ = 0;
  Time take_at_{};  ///< when the next lease is due
  Time wait_{};     ///< how long to wait after being told to
  WorkTally tally_;
};

}  // namespace parray::worker
