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

struct Lease {
  Epoch epoch = 0;
  CellRange range;
  bool divisible = false;  ///< its holder may return a part: see LeaseTable::arrive()
};

/// Who holds which cells of a pass: the state of PROTOCOL.md's picture "A lease".
///
/// Invariants: every cell is, at any moment, in exactly one of pending work, a lease, what is done.
/// An epoch is granted for one range only and never again. Plain state, no clock: `now` is an
/// argument. One thread. Costs of every call are logarithmic in the number of leases, but where
/// they are listed.
class LeaseTable {
 public:
  /// `pending` are the cells of the plan that are not done, ascending; epochs begin at
  /// `first_epoch`. A lease has `most_cells` at most.
  LeaseTable(const ChunkSizer& sizer, const std::vector<CellRange>& pending, Epoch first_epoch,
             std::uint64_t most_cells = UINT64_MAX);

  /// Leases the next cells to a worker of the machine `machine`: a check that the machine is to
  /// make, else pending work.
  std::optional<Lease> grant(Time deadline, WorkerId worker, const LeaseRequest& request,
                             const FarmSpeed& farm, MachineKey machine = 0);
  /// Leases a copy of the oldest lease of pending work that nobody else has a copy of yet.
  std::optional<Lease> grant_copy(Time deadline, WorkerId worker);

  /// Cells that are done and are to be traced once more.
  struct Check {
    CellRange range;
    MachineKey by = 0;            ///< the machine that traces them
    std::set<MachineKey> not_by;  ///< machines that must not: they traced the cells, or failed to
  };
  void want_check(Check check);
  /// Takes out the checks whose machine is not among `able`, or has failed to make them.
  std::vector<Check> take_orphans(const std::set<MachineKey>& able);
  /// Checks are wanted or leased.
  [[nodiscard]] bool checks_remain() const;

  enum class Arrival : std::uint8_t {
    stale,  ///< not a holder's, or of an epoch that is over: not to be looked at
    first,  ///< to be merged; then finish() or give_back()
    again,  ///< of cells that another holder's result is being merged of, or has been
    check,  ///< of cells that are done; then finish() or give_back()
  };
  struct Arrived {
    Arrival kind = Arrival::stale;
    CellRange range;                     ///< of the result
    std::vector<WorkerId> dropped = {};  ///< held copies of a lease that has come back in part
  };
  /// `worker` has returned the lease's first `cells` cells; 0: all of them. When the first result
  /// of a lease is a part, the other cells become pending again and the copies end. A part that
  /// comes after another result of the lease is stale.
  Arrived arrive(WorkerId worker, Epoch epoch, std::uint64_t cells = 0);
  /// A result that arrived as `first` or `check` is in. Returns who still holds a copy.
  std::vector<WorkerId> finish(Epoch epoch);
  /// A result, or a holder, was no good: the worker holds the lease no more. True if it did.
  bool give_back(WorkerId worker, Epoch epoch);
  /// Cells that were done are pending again.
  void put_back(const std::vector<CellRange>& ranges);

  /// Moves the deadline of a lease that `worker` holds, never back; false if it does not hold it.
  bool extend(WorkerId worker, Epoch epoch, Time deadline);
  /// Takes all its leases from a worker that is lost. Returns them.
  std::vector<Lease> drop_worker(WorkerId worker);
  struct Expired {
    Lease lease;
    WorkerId worker;
  };
  /// Takes leases whose deadline has passed from their holders.
  std::vector<Expired> expire(Time now);
  /// The next time at which expire() has something to do; `never` if nothing is leased.
  [[nodiscard]] Time next_deadline() const;

  [[nodiscard]] bool has_pending() const { return pending_cells_ > 0; }
  /// Nothing is pending, leased, or to be checked.
  [[nodiscard]] bool idle() const {
    return pending_cells_ == 0 && leased_.empty() && checks_.empty() && failed_checks_.empty();
  }
  [[nodiscard]] std::uint64_t pending_cells() const { return pending_cells_; }
  /// Of a lease that somebody holds.
  [[nodiscard]] std::optional<CellRange> range_of(Epoch epoch) const;
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

  Lease lease_out(const CellRange& range, WorkerId worker, Time deadline);
  CellRange take_pending(std::uint64_t cells);
  void add_pending(const CellRange& range);
  void hold(Leases::iterator lease, WorkerId worker, Time deadline);
  bool let_go(Leases::iterator lease, WorkerId worker);
  void retire_if_free(Leases::iterator lease);
  std::vector<WorkerId> shorten(Leases::iterator lease, std::uint64_t cells);

  ChunkSizer sizer_;
  std::uint64_t most_cells_;
  std::map<std::uint64_t, std::uint64_t> pending_;  ///< begin, end; apart and not touching
  std::uint64_t pending_cells_ = 0;
  std::uint64_t step_ = 0;
  Epoch next_epoch_;
  Leases leased_;
  std::set<std::pair<Time, Epoch>> deadlines_;  ///< of each holder
  std::map<WorkerId, std::size_t> held_;        ///< leases of each worker; no zeros
  std::map<Epoch, std::pair<CellRange, std::set<WorkerId>>> late_;  ///< who may still send a copy
  std::deque<Check> checks_;
  std::vector<Check> failed_checks_;
};

}  // namespace parray::coordinator
