#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/experiments/simulation/sim_window.h"
#include "tests/experiments/simulation/spent.h"
#include "worker/cell_team.h"

namespace parray::simulation {

/// Seconds that each cell of a plan takes one thread of speed 1, from those of the image's rows,
/// which a report's mpi.row_seconds has. `noise`: standard deviation of the logarithm of a cell's
/// part in its row. A row's total stays what it was.
std::vector<double> cell_costs(const WorkPlan& plan, const std::vector<std::uint32_t>& row_at,
                               const std::vector<double>& row_seconds, double noise,
                               std::uint64_t seed);

/// Which cells have been traced by anybody, and when the last one was.
struct TracedMap {
  std::vector<bool> cells;
  Time last{};
};

/// A team that takes virtual time: the cells of a range are dealt out to threads as OpenMP's
/// dynamic schedule does. Keeps an account of all that its cores do.
class SimCellTeam final : public CellTeam {
 public:
  struct Options {
    std::uint32_t threads = 1;
    double speed = 1;
    double ready = 0;      ///< seconds before the rank can ask for work
    double build = 0;      ///< seconds, before the first range
    double hand_over = 0;  ///< seconds, before every range
  };
  /// References outlive the team. `stops` are this rank's, in order.
  SimCellTeam(const WorkPlan& plan, const std::vector<double>& costs, TracedMap& map,
              const Clock& clock, std::vector<Stop> stops, const Options& options);

  void start(const CellRange& range) override;
  [[nodiscard]] bool busy() const override { return range_.has_value(); }
  std::optional<TracedCells> take() override;
  void abandon() override {}  // finish() accounts for it
  [[nodiscard]] std::uint64_t traced() const override;
  [[nodiscard]] bool building() const override { return busy() && clock_.now() < built_at_; }

  /// When the range at hand will be done; `never` without one.
  [[nodiscard]] Time due() const { return range_ ? due_ : never; }

  enum class Other : std::uint8_t { leases, coordinator };
  /// One of the rank's cores does something else in [begin, end).
  void share_core(Time begin, Time end, Other what);
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
  void give_up_range(Time end);
  void set_due();

  const WorkPlan& plan_;
  const std::vector<double>& costs_;
  TracedMap& map_;
  const Clock& clock_;
  const std::vector<Stop> stops_;
  const Options options_;
  std::optional<CellRange> range_;
  Dealt dealt_;
  double build_ = 0;  ///< seconds, in the range at hand
  Time begun_{};
  Time built_at_{};
  Time for_leases_{};  ///< by which share_core() has delayed the range at hand
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
