#include "coordinator/lease_table.h"

#include <algorithm>
#include <stdexcept>

namespace parray {
namespace {

/// A lease's result stays below 64 MiB, so that one message can carry it.
constexpr std::uint32_t most_block_pixels = (1U << 26) / sizeof(PixelSums);

/// Parts of `from` outside of `hole`, at most four.
std::vector<WorkRect> subtract(const WorkRect& from, const WorkRect& hole) {
  const std::uint32_t r0 = std::max(from.row_begin, hole.row_begin);
  const std::uint32_t r1 = std::min(from.row_end, hole.row_end);
  const std::uint32_t s0 = std::max(from.sample_begin, hole.sample_begin);
  const std::uint32_t s1 = std::min(from.sample_end, hole.sample_end);
  if (r0 >= r1 || s0 >= s1) {
    return {from};
  }
  std::vector<WorkRect> parts;
  for (const WorkRect& part :
       {WorkRect{from.row_begin, r0, from.sample_begin, from.sample_end},
        WorkRect{r0, r1, from.sample_begin, s0}, WorkRect{r0, r1, s1, from.sample_end},
        WorkRect{r1, from.row_end, from.sample_begin, from.sample_end}}) {
    if (part.row_begin < part.row_end && part.sample_begin < part.sample_end) {
      parts.push_back(part);
    }
  }
  return parts;
}

}  // namespace

LeaseTable::LeaseTable(const RenderSettings& settings, Epoch first_epoch)
    : policy_(settings.schedule),
      progressive_(settings.progressive),
      most_rows_(std::max(most_block_pixels / settings.width, 1U)),
      next_epoch_(first_epoch) {
  if (!settings.in_passes()) {
    add({0, settings.height, 0, settings.samples_per_pixel});
  }
}

void LeaseTable::add(const WorkRect& rect, double density) {
  WorkRect rest = rect;
  // Sums travel once for every part, so there are few.
  for (const std::uint32_t rung : {1U, 16U}) {
    if (progressive_ && rest.sample_begin < rung && rung < rest.sample_end) {
      add_later({rest.row_begin, rest.row_end, rest.sample_begin, rung}, density);
      rest.sample_begin = rung;
    }
  }
  add_later(rest, density);
}

void LeaseTable::add_later(const WorkRect& rect, double density) {
  total_units_ += rect.units();
  later_units_ += rect.units();
  later_.push_back({rect, density});
  if (pending_.empty()) {
    open_next();
  }
}

/// What waits first becomes pending.
void LeaseTable::open_next() {
  const Later next = later_.front();
  later_.pop_front();
  later_units_ -= next.rect.units();
  pending_ = {next.rect};
  pending_units_ = next.rect.units();
  opened_units_ = pending_units_;
  row_units_ = next.rect.samples();
  density_ = next.density;
  step_ = 0;
}

std::vector<WorkRect> LeaseTable::pending() const {
  std::vector<WorkRect> all(pending_.begin(), pending_.end());
  for (const Later& later : later_) {
    all.push_back(later.rect);
  }
  return all;
}

void LeaseTable::restore(const WorkRect& done) {
  std::deque<WorkRect> left;
  std::uint64_t left_units = 0;
  for (const WorkRect& rect : pending_) {
    for (const WorkRect& part : subtract(rect, done)) {
      left.push_back(part);
      left_units += part.units();
    }
  }
  std::deque<Later> later;
  std::uint64_t later_units = 0;
  for (const Later& work : later_) {
    for (const WorkRect& part : subtract(work.rect, done)) {
      later.push_back({part, work.density});
      later_units += part.units();
    }
  }
  if (left_units + later_units + done.units() != pending_units()) {
    throw std::logic_error("restoring samples that are done already");
  }
  pending_ = std::move(left);
  pending_units_ = left_units;
  later_ = std::move(later);
  later_units_ = later_units;
  done_units_ += done.units();
}

std::optional<Lease> LeaseTable::grant(Time deadline, const Asker& asker, bool may_copy) {
  if (pending_.empty() && !later_.empty()) {
    open_next();
  }
  if (pending_.empty()) {
    return may_copy ? grant_copy(deadline, asker.worker) : std::nullopt;
  }
  const ChunkRequest request{.total = std::max(opened_units_, pending_units_),
                             .remaining = pending_units_,
                             .step = step_++,
                             .row_units = row_units_,
                             .workers = std::max(asker.workers, 1U),
                             .threads = asker.threads,
                             .share = asker.share,
                             .least = asker.least_units,
                             .most = asker.most_units};
  const WorkRect rect = carve(chunk_units(policy_, request));
  const Epoch epoch = next_epoch_++;
  leased_.emplace(epoch, Leased{rect, {{asker.worker, deadline}}});
  ++held_[asker.worker];
  return Lease{epoch, rect, false};
}

/// Cuts about `units` from the first pending rectangle: whole rows of it, or, when that is less
/// than one, part of the samples of its first row.
WorkRect LeaseTable::carve(std::uint64_t units) {
  WorkRect& front = pending_.front();
  const auto rows = static_cast<std::uint32_t>(
      std::min<std::uint64_t>({units / front.samples(), front.rows(), most_rows_}));
  WorkRect piece = front;
  piece.row_end = front.row_begin + std::max(rows, 1U);
  front.row_begin = piece.row_end;
  if (front.rows() == 0) {
    pending_.pop_front();
  }
  if (rows == 0) {
    WorkRect rest = piece;
    piece.sample_end = piece.sample_begin + static_cast<std::uint32_t>(units);
    rest.sample_begin = piece.sample_end;
    pending_.push_front(rest);
  }
  pending_units_ -= piece.units();
  return piece;
}

std::optional<Lease> LeaseTable::grant_copy(Time deadline, WorkerId worker) {
  for (auto& [epoch, lease] : leased_) {  // oldest first
    const bool holds = std::any_of(lease.holders.begin(), lease.holders.end(),
                                   [&](const Holder& h) { return h.worker == worker; });
    if (!holds && lease.holders.size() < most_holders) {
      lease.holders.push_back({worker, deadline});
      ++held_[worker];
      return Lease{epoch, lease.rect, true};
    }
  }
  return {};
}

LeaseTable::Completion LeaseTable::complete(WorkerId worker, Epoch epoch, const WorkRect& rect,
                                            ResultDigest digest) {
  using enum msg::Verdict;
  if (const auto done = done_.find(epoch); done != done_.end()) {
    const bool same = done->second.first == rect && done->second.second == digest;
    return {same ? duplicate : mismatch, {}};
  }
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end() || !(lease->second.rect == rect)) {
    return {stale, {}};
  }
  Completion completion{accepted, {}};
  for (const Holder& holder : lease->second.holders) {
    let_go(holder.worker);
    if (holder.worker != worker) {
      completion.others.push_back(holder.worker);
    }
  }
  done_units_ += rect.units();
  done_.emplace(epoch, std::pair(rect, digest));
  leased_.erase(lease);
  return completion;
}

std::optional<WorkRect> LeaseTable::leased_rect(Epoch epoch) const {
  const auto lease = leased_.find(epoch);
  return lease == leased_.end() ? std::nullopt : std::optional(lease->second.rect);
}

bool LeaseTable::extend(WorkerId worker, Epoch epoch, Time deadline) {
  const auto lease = leased_.find(epoch);
  if (lease == leased_.end()) {
    return false;
  }
  for (Holder& holder : lease->second.holders) {
    if (holder.worker == worker) {
      holder.deadline = std::max(holder.deadline, deadline);
      return true;
    }
  }
  return false;
}

void LeaseTable::retire(std::map<Epoch, Leased>::iterator lease) {
  pending_.push_front(lease->second.rect);  // first in line: the rest of the image waits for it
  pending_units_ += lease->second.rect.units();
  leased_.erase(lease);
}

void LeaseTable::let_go(WorkerId worker) {
  const auto held = held_.find(worker);
  if (--held->second == 0) {
    held_.erase(held);
  }
}

std::vector<Epoch> LeaseTable::drop_worker(WorkerId worker) {
  std::vector<Epoch> dropped;
  for (auto lease = leased_.begin(); lease != leased_.end();) {
    const auto current = lease++;
    auto& holders = current->second.holders;
    if (std::erase_if(holders, [&](const Holder& h) { return h.worker == worker; }) == 0) {
      continue;
    }
    let_go(worker);
    dropped.push_back(current->first);
    if (holders.empty()) {
      retire(current);
    }
  }
  return dropped;
}

std::vector<LeaseTable::Expired> LeaseTable::expire(Time now) {
  std::vector<Expired> expired;
  for (auto lease = leased_.begin(); lease != leased_.end();) {
    const auto current = lease++;
    auto& holders = current->second.holders;
    for (const Holder& holder : holders) {
      if (holder.deadline <= now) {
        let_go(holder.worker);
        expired.push_back({current->first, holder.worker});
      }
    }
    std::erase_if(holders, [&](const Holder& h) { return h.deadline <= now; });
    if (holders.empty()) {
      retire(current);
    }
  }
  return expired;
}

Time LeaseTable::next_deadline() const {
  Time next = never;
  for (const auto& [epoch, lease] : leased_) {
    for (const Holder& holder : lease.holders) {
      next = std::min(next, holder.deadline);
    }
  }
  return next;
}

double LeaseTable::progress() const {
  return static_cast<double>(done_units_) / static_cast<double>(total_units_);
}

std::size_t LeaseTable::held_by(WorkerId worker) const {
  const auto held = held_.find(worker);
  return held == held_.end() ? 0 : held->second;
}

}  // namespace parray
