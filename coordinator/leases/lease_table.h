#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/schedule/chunk_sizer.h"
#include "common/schedule/work_plan.h"
#include "proto/clock.h"

namespace parray::coordinator {

using Epoch = std::uint64_t;
using WorkerId = std::uint64_t;
using MachineKey = std::uint64_t;  ///< machine_key()

/// The right of a worker to trace a range of cells.
struct Lease {
  Epoch epoch = 0;
  CellRange range;
  bool divisible = false;  ///< the holder may return a part: see LeaseTable::arrive()
};

/// Tracks which worker holds which cells of a pass. PROTOCOL.md, "A lease", shows the states.
///
/// Invariants: every cell is either pending, leased or done. An epoch is granted for one range only
/// and never again. Not thread-safe. Reads no clock: `now` is an argument. Every call takes
/// logarithmic time in the number of leases. Functions that list leases take linear time.
class LeaseTable {
 public:
  /// `pending`: the cells of the plan that are not done, in ascending order. `first_epoch`: the
  /// epoch of the first lease. `most_cells`: the largest size of a lease.
  LeaseTable(const ChunkSizer& sizer, const std::vector<CellRange>& pending, Epoch first_epoch,
             std::uint64_t most_cells = UINT64_MAX);

  /// Leases the next cells to a worker of the machine `machine`: a check that this machine should
  /// make, otherwise pending work. Returns nothing if there is neither.
  std::optional<Lease> grant(Time deadline, WorkerId worker, const LeaseRequest& request,
                             const FarmSpeed& farm, MachineKey machine = 0);
  /// Leases a copy of the oldest lease that `worker` does not hold, without a copy and not a check.
  std::optional<Lease> grant_copy(Time deadline, WorkerId worker);

  /// Done cells that another machine must trace again.
  struct Check {
    CellRange range;
    MachineKey by = 0;            ///< the machine that must trace them
    std::set<MachineKey> not_by;  ///< machines that traced the cells or failed at them
  };
  /// Adds a check.
  void want_check(Check check);
  /// Removes and returns the checks whose machine is not among `able` or failed to make them.
  std::vector<Check> take_orphans(const std::set<MachineKey>& able);
  /// Returns whether checks wait or are leased.
  [[nodiscard]] bool checks_remain() const;

  /// What the caller must do with a result.
  enum class Arrival : std::uint8_t {
    stale,  ///< the sender does not hold the lease, or the epoch has ended: discard the result
    first,  ///< merge it, then call finish() or give_back()
    again,  ///< compare it: another holder's result was or is being merged
    check,  ///< compare it with done cells, then call finish() or give_back()
  };
  struct Arrived {
    Arrival kind = Arrival::stale;
    CellRange range;                     ///< the cells of the result
    std::vector<WorkerId> dropped = {};  ///< workers whose copies ended, because a part arrived
  };
  /// Handles a result of `worker` for the lease's first `cells` cells; 0: all of them. If the first
  /// result of a lease is a part, the other cells become pending again and the copies end. A part
  /// that follows another result of the lease is stale.
  Arrived arrive(WorkerId worker, Epoch epoch, std::uint64_t cells = 0);
  /// Ends a lease whose result of kind `first` or `check` was merged or compared. Returns the
  /// workers that still hold a copy.
  std::vector<WorkerId> finish(Epoch epoch);
  /// Takes a lease from a worker after a failure or an invalid result. False: it did not hold it.
  bool give_back(WorkerId worker, Epoch epoch);
  /// Makes done cells pending again.
  void put_back(const std::vector<CellRange>& ranges);

  /// Moves the deadline of a lease, but never to an earlier time. False: `worker` does not hold it.
  bool extend(WorkerId worker, Epoch epoch, Time deadline);
  /// Takes all leases from a lost worker. Returns them.
  std::vector<Lease> drop_worker(WorkerId worker);
  struct Expired {
    Lease lease;
    WorkerId worker;
  };
  /// Takes the leases whose deadlines have passed from their holders. Returns them.
  std::vector<Expired> expire(Time now);
  /// Returns the next time at which a lease expires; `never` if none is leased.
  [[nodiscard]] Time next_deadline() const;

  [[nodiscard]] bool has_pending() const { return pending_cells_ > 0; }
  /// Returns whether nothing is pending or leased and no check remains.
  [[nodiscard]] bool idle() const {
    return pending_cells_ == 0 && leased_.empty() && checks_.empty() && failed_checks_.empty();
  }
  [[nodiscard]] std::uint64_t pending_cells() const { return pending_cells_; }
  /// Returns the range of a lease. Nothing: no worker holds it.
  [[nodiscard]] std::optional<CellRange> range_of(Epoch epoch) const;
  /// Returns the number of leases that a worker holds.
  [[nodiscard]] std::size_t held_by(WorkerId worker) const;
  [[nodiscard]] std::size_t leased() const { return leased_.size(); }
  [[nodiscard]] Epoch next_epoch() const { return next_epoch_; }

  static constexpr std::size_t most_holders = 2;

 private:
  struct Holder {
    WorkerId worker;
    Time deadline;
  };
  struct Leased {
    CellRange range;
    std::vector<Holder> holders;
    bool arrived = false;  ///< a result is being merged: no deadline, no other copy
    std::optional<Check> check{};
  };
  using Leases = std::map<Epoch, Leased>;

  Lease add_lease(const CellRange& range, WorkerId worker, Time deadline);
  CellRange take_pending(std::uint64_t cells);
  void add_pending(const CellRange& range);
  void hold(Leases::iterator lease, WorkerId worker, Time deadline);
  bool release(Leases::iterator lease, WorkerId worker);
  void retire_if_free(Leases::iterator lease);
  std::vector<WorkerId> shorten(Leases::iterator lease, std::uint64_t cells);

  ChunkSizer sizer_;
  std::uint64_t most_cells_;
  std::map<std::uint64_t, std::uint64_t> pending_;  ///< begin and end; adjacent ranges are joined
  std::uint64_t pending_cells_ = 0;
  std::uint64_t step_ = 0;
  Epoch next_epoch_;
  Leases leased_;
  std::set<std::pair<Time, Epoch>> deadlines_;  ///< deadlines of all holders
  std::map<WorkerId, std::size_t> held_;        ///< leases of each worker; no zeros
  std::map<Epoch, std::pair<CellRange, std::set<WorkerId>>>
      late_;  ///< workers whose copies may still arrive
  std::deque<Check> checks_;
  std::vector<Check> failed_checks_;
};

}  // namespace parray::coordinator
