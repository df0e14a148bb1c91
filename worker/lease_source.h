#pragma once

#include <cstdint>

#include "proto/clock.h"
#include "worker/team.h"

namespace parray::worker {

/// The work that a team has done, for one source or for several in succession.
struct WorkTally {
  std::uint64_t samples = 0;  ///< samples of finished leases
  std::uint64_t leases = 0;   ///< leases taken
  Time taking{};              ///< time spent taking leases
  Time putting{};             ///< time spent handing in results
  double busy = 0;            ///< seconds of tracing
  // The fields below are those of the latest LeaseResult with cells.
  double build_seconds = 0;             ///< seconds of building the accelerator
  std::uint64_t accelerator_bytes = 0;  ///< memory of the accelerator
};

/// The progress of a team.
struct TeamState {
  std::uint64_t traced = 0;  ///< samples, see Team::traced()
  bool tracing = false;      ///< has a lease
  bool preparing = false;    ///< builds an accelerator
};

/// The source of leases and the receiver of results: messages or a window. Not thread-safe.
class LeaseSource {
 public:
  virtual ~LeaseSource() = default;

  enum class Answer : std::uint8_t {
    lease,  ///< trace it
    wait,   ///< nothing to do now: ask again in a few milliseconds
    none,   ///< nothing to do until something arrives: ask in the next turn
    over    ///< no more work will follow
  };
  struct Taken {
    Answer answer = Answer::none;
    LeaseWork lease{};
    bool fresh = true;  ///< false: a further part of the previous lease
    /// Approximate samples of the lease. 0: unknown; then the runner takes the next lease only
    /// after this one is done.
    double samples = 0;
  };
  /// Returns a lease, or a part of one that is handed in separately. `samples_per_second` is the
  /// measured speed of the team; 0: not yet measured. `idle` means that the team has nothing to do.
  /// Then a copy of another worker's unfinished lease is better than nothing.
  virtual Taken take(Time now, double samples_per_second, bool idle) = 0;

  /// Hands in the result of a lease that take() returned. Throws RunError if the lease failed and
  /// the source cannot report that.
  virtual void complete(Time now, LeaseResult finished) = 0;

  /// Returns whether a lease that take() returned is still worth tracing.
  [[nodiscard]] virtual bool wants(const LeaseKey& /*lease*/) const { return true; }

  /// Sends heartbeats and repeats messages without a reply. Returns the time when it is due again.
  virtual Time tick(Time now, const TeamState& team) = 0;

  /// Reports the work done, if the source collects such reports.
  virtual void report(const WorkTally& /*tally*/) {}
};

}  // namespace parray::worker
