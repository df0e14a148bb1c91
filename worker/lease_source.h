#pragma once

#include <cstdint>
#include <string>

#include "proto/clock.h"
#include "worker/team.h"

namespace parray::worker {

/// What a team has done for a source.
struct WorkTally {
  std::uint64_t samples = 0;
  std::uint64_t leases = 0;  ///< taken
  Time taking{};             ///< spent in taking them
  Time putting{};            ///< spent in handing in results
  double busy = 0;           ///< seconds of tracing
  double build_seconds = 0;  ///< of the accelerator, as the latest result has it; and so on
  std::uint64_t accelerator_bytes = 0;
  std::string isa;
};

/// How a team is getting on.
struct TeamState {
  std::uint64_t traced = 0;
  bool tracing = false;    ///< has a lease
  bool preparing = false;  ///< builds an accelerator
};

/// Where leases come from and results go: messages, or a window. One thread.
class LeaseSource {
 public:
  virtual ~LeaseSource() = default;

  enum class Answer : std::uint8_t {
    lease,  ///< trace it
    wait,   ///< nothing to do now: ask again in a few milliseconds
    none,   ///< nothing to do until something arrives: ask at the next turn
    over    ///< nothing will be left to do
  };
  struct Taken {
    Answer answer = Answer::none;
    Assignment lease{};
    bool fresh = true;  ///< not a further part of the lease before
    /// Of the lease, about; 0: unknown, and the next one is wanted when it is done, no sooner.
    double samples = 0;
  };
  /// A lease, or a part of one that is handed in by itself. `samples_per_second`: of the team, as
  /// measured; 0: not yet. `idle`: the team has nothing to do, so that a copy of what others have
  /// not finished is better than nothing.
  virtual Taken take(Time now, double samples_per_second, bool idle) = 0;

  /// Hands in what take() has given out. Throws RunError where a failure cannot be told to anybody.
  virtual void complete(Time now, Finished finished) = 0;

  /// Whether a lease that take() has given out is still worth tracing.
  [[nodiscard]] virtual bool wants(const LeaseKey& /*lease*/) const { return true; }

  /// Says that this side is alive, and repeats what was not heard. Returns when it is due again.
  virtual Time tick(Time now, const TeamState& team) = 0;

  /// Says what has been done, where somebody asks for that.
  virtual void report(const WorkTally& /*tally*/) {}
};

}  // namespace parray::worker
