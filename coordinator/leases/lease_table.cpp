#include "coordinator/leases/lease_table.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace parray::coordinator {

LeaseTable::LeaseTable(const ChunkSizer& sizer, const std::vector<CellRange>& pending,
                       Epoch first_epoch, std::uint64_t most_cells)
    : sizer_(sizer), most_cells_(std::max<std::uint64_t>(most_cells, 1)), next_epoch_(first_epoch) {
  for (const CellRange& range : pending) add_pending(range);
}

void LeaseTable::add_pending(const CellRange& range) {
  auto next = pending_.upper_bound(range.begin);
  if ((next != pending_.end() && next->first < range.end) ||
      (next != pending_.begin() && std::prev(next)->second > range.begin)) {
    throw std::logic_error("LeaseTable: these cells are pending already");
  }
  pending_cells_ += range.count();
  CellRange merged = range;
  if (next != pending_.end() && next->first == range.end) {
    merged.end = next->second;
    next = pending_.erase(next);
  }
  if (next != pending_.begin() && std::prev(next)->second == range.begin) {
    std::prev(next)->second = merged.end;
    return;
  }
  pending_.emplace(merged.begin, merged.end);
}

/// Takes the first pending cells. So cells that were given back come before later ones.
CellRange LeaseTable::take_pending(std::uint64_t cells) {
  const auto first = pending_.begin();
  const CellRange range{first->first, std::min(first->second, first->first + cells)};
  const std::uint64_t end = first->second;
  pending_.erase(first);
  if (range.end < end) pending_.emplace(range.end, end);
  pending_cells_ -= range.count();
  return range;
}

void LeaseTable::hold(Leases::iterator lease, WorkerId worker, Time deadline) {
  lease->second.holders.push_back({worker, deadline});
  deadlines_.emplace(deadline, lease->first);
  ++held_[worker];
}

Lease LeaseTable::add_lease(const CellRange& range, WorkerId worker, Time deadline) {
  const Epoch epoch = next_epoch_++;
  hold(leased_.emplace(epoch, Leased{range, {}}).first, worker, deadline);
  return {epoch, range, true};
}

std::optional<Lease> LeaseTable::grant(Time deadline, WorkerId worker, const LeaseRequest& request,
                                       const FarmSpeed& farm, MachineKey machine) {
  const auto check = std::ranges::find(checks_, machine, &Check::by);
  if (machine != 0 && check != checks_.end()) {
    Check wanted = std::move(*check);
    checks_.erase(check);
    Lease lease = add_lease(wanted.range, worker, deadline);
    lease.divisible = false;
    leased_.at(lease.epoch).check = std::move(wanted);
    return lease;
  }
  if (pending_cells_ == 0) return {};
  const std::uint64_t cells = sizer_.cells(request, farm, pending_cells_, step_++);
  return add_lease(take_pending(std::min(cells, most_cells_)), worker, deadline);
}

std::optional<Lease> LeaseTable::grant_copy(Time deadline, WorkerId worker) {
  for (auto lease = leased_.begin(); lease != leased_.end(); ++lease) {  // oldest first
    const Leased& leased = lease->second;
    const bool holds =
        std::ranges::any_of(leased.holders, [&](const Holder& h) { return h.worker == worker; });
    if (!holds && !leased.check && !leased.arrived && leased.holders.size() < most_holders) {
      hold(lease, worker, deadline);
      return Lease{lease->first, leased.range};
    }
  }
  return {};
}

std::vector<LeaseTable::Check> LeaseTable::take_orphans(const std::set<MachineKey>& able) {
  std::vector<Check> orphans = std::exchange(failed_checks_, {});
  for (auto check = checks_.begin(); check != checks_.end();) {
    if (able.contains(check->by)) {
      ++check;
    } else {
      orphans.push_back(std::move(*check));
      check = checks_.erase(check);
    }
  }
  return orphans;
}

bool LeaseTable::checks_remain() const {
  return !checks_.empty() || !failed_checks_.empty() ||
         std::ranges::any_of(leased_,
                             [](const auto& lease) { return lease.second.check.has_value(); });
}

bool LeaseTable::release(Leases::iterator lease, WorkerId worker) {
  auto& holders = lease->second.holders;
  const auto holder = std::ranges::find(holders, worker, &Holder::worker);
  if (holder == holders.end()) return false;
  // If another holder has the same deadline, its entry stays.
  const bool shared = std::ranges::any_of(holders, [&](const Holder& h) {
    return h.worker != worker && h.deadline == holder->deadline;
  });
  if (!shared) deadlines_.erase({holder->deadline, lease->first});
  holders.erase(holder);
  const auto held = held_.find(worker);
  if (--held->second == 0) held_.erase(held);
  return true;
}

/// Ends a lease without holders: its cells become pending, or its check has failed. `lost`: the
/// last holder did not give it back.
void LeaseTable::retire_if_free(Leases::iterator lease, bool lost) {
  if (!lease->second.holders.empty() || lease->second.arrived) return;
  if (lease->second.check) {
    Check& check = *lease->second.check;
    if (!lost || ++losses_[check.by] >= most_losses) check.not_by.insert(check.by);
    failed_checks_.push_back(std::move(check));
  } else {
    add_pending(lease->second.range);
  }
  leased_.erase(lease);
}

static bool is_part(const CellRange& range, std::uint64_t cells) {
  return cells > 0 && cells < range.count();
}

/// Takes a lease from all its holders, and returns them.
std::vector<WorkerId> LeaseTable::release_all(Leases::iterator lease) {
  std::vector<WorkerId> holders;
  for (const Holder& holder : lease->second.holders) holders.push_back(holder.worker);
  for (const WorkerId holder : holders) release(lease, holder);
  return holders;
}

LeaseTable::Arrived LeaseTable::arrive(WorkerId worker, Epoch epoch, std::uint64_t cells) {
  if (const auto late = late_.find(epoch); late != late_.end()) {
    if (late->second.second.erase(worker) == 0) return {};
    const CellRange range = late->second.first;
    if (late->second.second.empty()) late_.erase(late);
    return is_part(range, cells) ? Arrived() : Arrived{Arrival::again, range};
  }
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end() || !release(lease, worker)) return {};
  CellRange& range = lease->second.range;
  if (std::exchange(lease->second.arrived, true)) {
    return is_part(range, cells) ? Arrived() : Arrived{Arrival::again, range};
  }
  if (lease->second.check) return {Arrival::check, range};
  if (!is_part(range, cells)) return {Arrival::first, range};
  const std::uint64_t end = std::exchange(range.end, range.begin + cells);
  add_pending({range.end, end});
  return {Arrival::first, range, release_all(lease)};
}

std::vector<WorkerId> LeaseTable::finish(Epoch epoch) {
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end()) return {};
  if (lease->second.check) losses_.erase(lease->second.check->by);
  std::vector<WorkerId> others = release_all(lease);
  if (!others.empty()) {
    late_.emplace(epoch,
                  std::pair(lease->second.range, std::set<WorkerId>(others.begin(), others.end())));
  }
  leased_.erase(lease);
  return others;
}

void LeaseTable::reject(Epoch epoch) {
  const auto lease = leased_.find(epoch);
  if (lease != leased_.end()) {
    lease->second.arrived = false;
    retire_if_free(lease, false);
  }
}

bool LeaseTable::give_back(WorkerId worker, Epoch epoch) {
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end() || !release(lease, worker)) return false;
  retire_if_free(lease, false);
  return true;
}

void LeaseTable::put_back(const std::vector<CellRange>& ranges) {
  for (const CellRange& range : ranges) add_pending(range);
}

bool LeaseTable::extend(WorkerId worker, Epoch epoch, Time deadline) {
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end()) return false;
  const auto holder = std::ranges::find(lease->second.holders, worker, &Holder::worker);
  if (holder == lease->second.holders.end()) return false;
  if (deadline > holder->deadline) {
    release(lease, worker);
    hold(lease, worker, deadline);
  }
  return true;
}

std::vector<Lease> LeaseTable::drop_worker(WorkerId worker) {
  std::vector<Lease> dropped;
  for (auto lease = leased_.begin(); lease != leased_.end() && held_by(worker) > 0;) {
    const auto current = lease++;
    if (release(current, worker)) {
      dropped.push_back({current->first, current->second.range});
      retire_if_free(current, true);
    }
  }
  for (auto late = late_.begin(); late != late_.end();) {
    late->second.second.erase(worker);
    late = late->second.second.empty() ? late_.erase(late) : std::next(late);
  }
  return dropped;
}

std::vector<LeaseTable::Expired> LeaseTable::expire(Time now) {
  std::vector<Expired> expired;
  while (!deadlines_.empty() && deadlines_.begin()->first <= now) {
    const auto lease = leased_.find(deadlines_.begin()->second);
    for (const Holder& holder : std::vector<Holder>(lease->second.holders)) {
      if (holder.deadline <= now) {
        expired.push_back({{lease->first, lease->second.range}, holder.worker});
        release(lease, holder.worker);
      }
    }
    retire_if_free(lease, true);
  }
  return expired;
}

Time LeaseTable::next_deadline() const {
  return deadlines_.empty() ? never : deadlines_.begin()->first;
}

std::optional<CellRange> LeaseTable::range_of(Epoch epoch) const {
  const auto lease = leased_.find(epoch);
  return lease == leased_.end() ? std::nullopt : std::optional(lease->second.range);
}

std::size_t LeaseTable::held_by(WorkerId worker) const {
  const auto held = held_.find(worker);
  return held == held_.end() ? 0 : held->second;
}

}  // namespace parray::coordinator
