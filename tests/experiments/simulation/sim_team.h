#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/schedule/work_plan.h"
#include "tests/experiments/simulation/sim_window.h"
#include "tests/experiments/simulation/spent.h"
#include "tests/support/rooms.h"
#include "worker/team.h"

namespace parray::simulation {

/// Seconds that each cell of a plan takes one thread of speed 1, from those of the image's rows,
/// which a report's mpi.row_seconds has. `noise`: standard deviation of the logarithm of a cell's
/// part in its row. A row's total stays what it was.
std::vector<double> cell_costs(const WorkPlan& plan, const std::vector<double>& row_seconds,
                               double noise, std::uint64_t seed);

/// Which cells have been traced by anybody, and when the last one was.
struct TracedMap {
  std::vector<bool> cells;
  Time last{};
};

/// A team that takes virtual time: the cells of a lease are dealt out to threads as OpenMP's
/// dynamic schedule does. Keeps an account of all that its cores do.
class SimCellTeam final : public Team {
 public:
  struct Options {
    std::uint32_t threads = 1;
    double speed = 1;
    double ready = 0;      ///< seconds before the rank can ask for work
    double build = 0;      ///< seconds, before the first lease
    double hand_over = 0;  ///< seconds, before every lease
  };
  /// References outlive the team. `stops` are this rank's, in order.
  SimCellTeam(const WorkPlan& plan, const std::vector<double>& costs, TracedMap& map,
              const Clock& clock, std::vector<Stop> stops, const Options& options);

  void start(LeaseWork assignment) override;
  [[nodiscard]] bool idle() const override { return !lease_; }
  std::optional<LeaseResult> take() override;
  void abandon() override {}  // finish() accounts for it
  [[nodiscard]] std::uint64_t traced() const override;
  [[nodiscard]] bool preparing() const override { return lease_ && clock_.now() < built_at_; }

  /// When the lease at hand will be done; `never` without one.
  [[nodiscard]] Time due() const { return lease_ ? due_ : never; }

  enum class Other : std::uint8_t { leases, coordinator };
  /// `cores` of the rank's do something else in [begin, end).
  void share_core(Time begin, Time end, Other what, std::uint32_t cores = 1);
  /// Nothing is left to be leased.
  void note_waiting() { waiting_ = true; }

  /// What the cores have done until `end`.
  Spent finish(Time end);
  [[nodiscard]] double speed() const { return options_.speed; }

 private:
  struct Dealt {
    double length = 0;  ///< until the last thread is done
    double work = 0;    ///< of all threads
  };
  [[nodiscard]] Dealt deal(const CellRange& range) const;
  [[nodiscard]] double stopped_seconds(Time begin, Time end) const;
  struct Gap {
    Time begin;
    Time end;
    bool nothing_left;
  };
  void close(const Gap& gap);
  void give_up_lease(Time end);
  void set_due();

  const WorkPlan& plan_;
  const std::vector<double>& costs_;
  TracedMap& map_;
  const Clock& clock_;
  const std::vector<Stop> stops_;
  const Options options_;
  std::optional<LeaseWork> lease_;
  Dealt dealt_;
  double build_ = 0;  ///< seconds, in the lease at hand
  Time begun_{};
  Time built_at_{};
  Time for_leases_{};  ///< by which share_core() has delayed the lease at hand
  Time for_coordinator_{};
  Time due_{};
  Time idle_since_;
  bool built_ = false;
  bool waiting_ = false;
  std::vector<Gap> gaps_;
  std::uint64_t samples_ = 0;
  Spent spent_;
};

}  // namespace parray::simulation
