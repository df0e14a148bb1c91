#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/image/row_block.h"
#include "common/schedule/chunk_policy.h"
#include "proto/clock.h"
#include "proto/messages.h"

namespace parray {

using Epoch = std::uint64_t;
using WorkerId = std::uint64_t;

/// A hash of a result's bytes, to tell equal results from others.
using ResultDigest = std::uint64_t;

struct Lease {
  Epoch epoch = 0;
  WorkRect rect;
  bool copy = false;  ///< somebody else holds it too
};

/// What the asking worker looks like to a policy; see ChunkRequest.
struct Asker {
  WorkerId worker = 0;
  std::uint32_t threads = 1;
  double share = 1;
  std::uint32_t workers = 1;
  std::uint64_t least_units = 1;
  std::uint64_t most_units = UINT64_MAX;
};

/// Who holds which samples of one job: the state of PROTOCOL.md's picture "A lease".
///
/// Invariants: every sample of the job is, at any moment, in exactly one of pending work, a leased
/// rectangle, a done rectangle. An epoch is granted for one rectangle only and never again.
/// Plain state, no clock: `now` is an argument. One thread.
class LeaseTable {
 public:
  /// All samples of `settings` (resolved) are pending; none if the job goes in passes. Epochs start
  /// at `first_epoch`.
  LeaseTable(const RenderSettings& settings, Epoch first_epoch = 1);

  /// More work: handed out after what is pending, as a job of its own as far as the policy goes.
  /// `density`: the share of its samples that pixels have, on average, 0 .. 1. Where the settings
  /// are progressive, the first samples of a picture come before the others.
  void add(const WorkRect& rect, double density = 1);
  /// Of the work that is being handed out.
  [[nodiscard]] double density() const { return density_; }

  /// Marks a rectangle as done from an earlier life of the job. Only before the first grant.
  void restore(const WorkRect& done);

  /// Leases the next piece of pending work. When none is left and `may_copy`, leases a copy of the
  /// oldest lease that the asker does not hold, at most `most_holders` of each.
  std::optional<Lease> grant(Time deadline, const Asker& asker, bool may_copy);

  struct Completion {
    msg::Verdict verdict = msg::Verdict::stale;
    std::vector<WorkerId> others;  ///< still hold a copy and may stop
  };

  /// A result has come in from `worker`. On `accepted` the caller must merge the block, now and
  /// only now. `rect` is the block's; one that is not the lease's is stale, whatever its epoch.
  Completion complete(WorkerId worker, Epoch epoch, const WorkRect& rect, ResultDigest digest);

  /// The rectangle of a lease that somebody holds.
  [[nodiscard]] std::optional<WorkRect> leased_rect(Epoch epoch) const;

  /// Moves the deadline of a lease that `worker` holds, never back; false if it does not hold it.
  bool extend(WorkerId worker, Epoch epoch, Time deadline);

  /// Takes all its leases from a worker that is lost. Returns their epochs.
  std::vector<Epoch> drop_worker(WorkerId worker);

  struct Expired {
    Epoch epoch;
    WorkerId worker;
  };
  /// Takes leases whose deadline has passed from their holders.
  std::vector<Expired> expire(Time now);

  /// The next time at which expire() has something to do; `never` if nothing is leased.
  [[nodiscard]] Time next_deadline() const;

  /// What nobody holds and is not done, in the order in which it would be handed out.
  [[nodiscard]] std::vector<WorkRect> pending() const;
  [[nodiscard]] bool has_pending() const { return !pending_.empty() || !later_.empty(); }
  [[nodiscard]] bool done() const { return done_units_ == total_units_; }
  [[nodiscard]] double progress() const;
  [[nodiscard]] std::uint64_t pending_units() const { return pending_units_ + later_units_; }
  [[nodiscard]] std::uint64_t done_units() const { return done_units_; }
  [[nodiscard]] std::uint64_t total_units() const { return total_units_; }
  [[nodiscard]] std::size_t leased() const { return leased_.size(); }
  [[nodiscard]] std::size_t held_by(WorkerId worker) const;

  static constexpr std::size_t most_holders = 2;

 private:
  struct Holder {
    WorkerId worker;
    Time deadline;
  };
  struct Leased {
    WorkRect rect;
    std::vector<Holder> holders;
  };

  [[nodiscard]] WorkRect carve(std::uint64_t units);
  std::optional<Lease> grant_copy(Time deadline, WorkerId worker);
  void retire(std::map<Epoch, Leased>::iterator lease);
  void let_go(WorkerId worker);

  void add_later(const WorkRect& rect, double density);
  void open_next();

  struct Later {
    WorkRect rect;
    double density;
  };

  SchedulePolicy policy_;
  bool progressive_;
  std::uint32_t most_rows_;         ///< of one lease
  std::uint64_t total_units_ = 0;   ///< of all work so far
  std::uint64_t opened_units_ = 0;  ///< of the work that is being handed out: the policy's total
  std::uint64_t row_units_ = 1;     ///< of a whole row of it
  double density_ = 1;
  std::uint64_t pending_units_ = 0;  ///< of pending_
  std::uint64_t done_units_ = 0;
  std::uint64_t step_ = 0;
  Epoch next_epoch_;
  std::deque<WorkRect> pending_;  ///< handed out from the front
  std::deque<Later> later_;       ///< when pending_ is empty
  std::uint64_t later_units_ = 0;
  std::map<Epoch, Leased> leased_;
  std::map<WorkerId, std::size_t> held_;                     ///< leases of each worker; no zeros
  std::map<Epoch, std::pair<WorkRect, ResultDigest>> done_;  ///< what duplicates are compared with
};

}  // namespace parray
