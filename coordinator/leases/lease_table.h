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

using Epoch = std::uint64_t;       ///< number of a lease; a copy of the lease has the same number
using WorkerId = std::uint64_t;    ///< number of a connection of a worker to this coordinator
using MachineKey = std::uint64_t;  ///< value of machine_key() in machine_id.h

/// The right of a worker to trace a range of cells.
struct Lease {
  Epoch epoch = 0;
  CellRange range;
  /// The holder may return a result for the first cells only: see LeaseTable::arrive(). False for
  /// copies and checks.
  bool divisible = false;
};

/// Tracks which worker holds which cells of a pass. PROTOCOL.md, "A lease", shows the states.
///
/// A cell is pending (it waits for a lease), leased or done (merged); exactly one of these holds.
/// The lease of a check covers done cells, which stay done. A lease ends when finish() is called,
/// or when it has no holder left and no result of it is being merged. The epoch of a lease is never
/// granted for another one.
///
/// Not thread-safe. Reads no clock: `now` is an argument. Calls take logarithmic time in the number
/// of leases. Only grant_copy(), checks_remain() and drop_worker() take linear time. grant() and
/// take_orphans() also take linear time in the number of waiting checks.
class LeaseTable {
 public:
  /// `sizer` computes the sizes of leases. `pending`: the cells of the plan that are not done, in
  /// ascending order. `first_epoch`: the epoch of the first lease. `most_cells`: the largest size
  /// of a lease.
  LeaseTable(const ChunkSizer& sizer, const std::vector<CellRange>& pending, Epoch first_epoch,
             std::uint64_t most_cells = UINT64_MAX);

  /// Leases cells to `worker`: those of a waiting check whose `by` is `machine`, otherwise the
  /// first pending cells. Returns nothing if there are neither. `request` (the worker's threads and
  /// speed) and `farm` determine how many pending cells it leases. `machine`: the machine of the
  /// worker; 0: the worker gets no checks.
  std::optional<Lease> grant(Time deadline, WorkerId worker, const LeaseRequest& request,
                             const FarmSpeed& farm, MachineKey machine = 0);
  /// Leases to `worker` a copy of another worker's lease, with the same range and epoch. Takes the
  /// oldest lease that meets three conditions: another worker is its only holder, its result has
  /// not arrived, and it is not a check. Returns nothing if there is no such lease.
  std::optional<Lease> grant_copy(Time deadline, WorkerId worker);

  /// A check: done cells that a certain machine must trace again, so that the bits can be compared.
  struct Check {
    CellRange range;
    MachineKey by = 0;  ///< the machine that must trace them; 0: not chosen yet
    /// Machines that must not make the check: those that traced the cells first, and those that
    /// failed: see take_orphans().
    std::set<MachineKey> not_by;
  };
  /// Adds a check. It waits until grant() leases it to a worker of the machine `by`.
  void want_check(Check check) { checks_.push_back(std::move(check)); }
  /// Removes and returns the checks that need another machine: the waiting checks whose `by` is not
  /// among `able`, and the failed checks. A check fails if its lease ends without a valid result.
  /// `able`: the machines with a worker that may trace.
  ///
  /// If reject() or give_back() ended the lease, `not_by` of the failed check contains the machine.
  /// If drop_worker() or expire() ended it, `not_by` contains the machine only if the machine has
  /// lost the leases of most_losses checks in a row.
  std::vector<Check> take_orphans(const std::set<MachineKey>& able);
  /// Returns whether a check waits, is leased, or has failed and take_orphans() has not returned it
  /// yet.
  [[nodiscard]] bool checks_remain() const;

  /// The action that the caller must take on a result.
  enum class Arrival : std::uint8_t {
    /// Discard it: the sender has never held this lease, has lost it, or has returned a result
    /// before. Also a part that follows another result of the lease.
    stale,
    first,  ///< merge it, then call finish(); if it is invalid, call reject()
    /// Compare it with the result of the other holder, which came first. Call neither finish() nor
    /// reject().
    again,
    /// Compare it with the done cells, then call finish(); if it is invalid, call reject().
    check,
  };
  struct Arrived {
    Arrival kind = Arrival::stale;
    CellRange range;                     ///< the cells of the result; empty if stale
    std::vector<WorkerId> dropped = {};  ///< workers that lost the lease, because a part arrived
  };
  /// Handles a result of `worker` for the first `cells` cells of the lease; 0: for all of them. A
  /// check always counts as whole. Afterwards `worker` no longer holds the lease. If the first
  /// result of a lease is a part, the range of the lease shrinks to these cells, and the other
  /// cells become pending again. Then the other holder, if any, loses the lease: its result will be
  /// stale.
  Arrived arrive(WorkerId worker, Epoch epoch, std::uint64_t cells = 0);
  /// Ends a lease whose result of the kind `first` or `check` was merged or compared. Returns the
  /// other holders, which lose the lease. If such a worker returns a whole result later, the result
  /// is still of the kind `again`. Returns none for a lease that has ended.
  std::vector<WorkerId> finish(Epoch epoch);
  /// Discards the result of the kind `first` or `check` of a lease, because the result is invalid.
  /// Another holder keeps the lease. Without another holder, the cells become pending again; if the
  /// lease is that of a check, the check has failed.
  void reject(Epoch epoch);
  /// Takes a lease from a holder that failed, with the consequences of reject(). False: the worker
  /// does not hold this lease.
  bool give_back(WorkerId worker, Epoch epoch);
  /// Makes done cells pending again. Throws std::logic_error if a cell is pending already.
  void put_back(const std::vector<CellRange>& ranges);

  /// Moves the deadline of a worker's lease, but never to an earlier time. False: `worker` does not
  /// hold the lease.
  bool extend(WorkerId worker, Epoch epoch, Time deadline);
  /// Takes all leases from a lost worker, with the consequences of reject(). take_orphans() says
  /// what differs for checks. Returns the leases.
  std::vector<Lease> drop_worker(WorkerId worker);
  struct Expired {
    Lease lease;
    WorkerId worker;
  };
  /// Takes the leases whose deadlines have passed from their holders, as drop_worker() does.
  /// Returns these leases.
  std::vector<Expired> expire(Time now);
  /// Returns the earliest deadline of all holders; `never` if there is no holder. A worker whose
  /// result has arrived is not a holder.
  [[nodiscard]] Time next_deadline() const;

  /// Returns whether nothing is pending or leased and no check remains.
  [[nodiscard]] bool idle() const {
    return pending_cells_ == 0 && leased_.empty() && checks_.empty() && failed_checks_.empty();
  }
  [[nodiscard]] std::uint64_t pending_cells() const { return pending_cells_; }
  /// Returns the range of a lease. Nothing: the lease has ended, or has never existed.
  [[nodiscard]] std::optional<CellRange> range_of(Epoch epoch) const;
  /// Returns the number of leases of this table that a worker holds.
  [[nodiscard]] std::size_t held_by(WorkerId worker) const;
  [[nodiscard]] std::size_t leased() const { return leased_.size(); }
  [[nodiscard]] Epoch next_epoch() const { return next_epoch_; }

  static constexpr int most_losses = 3;  ///< see take_orphans()
  /// Most workers that hold one lease: the worker that got it first, and one with a copy.
  static constexpr std::size_t most_holders = 2;

 private:
  struct Holder {
    WorkerId worker;
    Time deadline;
  };
  struct Leased {
    CellRange range;
    std::vector<Holder> holders;
    bool arrived = false;  ///< the first result is being merged: grant_copy() makes no copy
    std::optional<Check> check{};
  };
  using Leases = std::map<Epoch, Leased>;

  Lease add_lease(const CellRange& range, WorkerId worker, Time deadline);
  CellRange take_pending(std::uint64_t cells);
  void add_pending(const CellRange& range);
  void hold(Leases::iterator lease, WorkerId worker, Time deadline);
  bool release(Leases::iterator lease, WorkerId worker);
  void retire_if_free(Leases::iterator lease, bool lost);
  std::vector<WorkerId> release_all(Leases::iterator lease);

  ChunkSizer sizer_;
  std::uint64_t most_cells_;
  std::map<std::uint64_t, std::uint64_t> pending_;  ///< begin and end; adjacent ranges are joined
  std::uint64_t pending_cells_ = 0;
  /// Number of granted leases that were no checks: see ChunkSizer::cells().
  std::uint64_t step_ = 0;
  Epoch next_epoch_;
  Leases leased_;
  std::set<std::pair<Time, Epoch>> deadlines_;  ///< deadlines of all holders
  std::map<WorkerId, std::size_t> held_;        ///< leases of each worker; no zeros
  std::map<Epoch, std::pair<CellRange, std::set<WorkerId>>>
      late_;  ///< workers whose copies may still arrive
  std::deque<Check> checks_;
  std::vector<Check> failed_checks_;
  std::map<MachineKey, int> losses_;  ///< leases of checks that a machine lost in a row
};

}  // namespace parray::coordinator
