#include "tests/experiments/simulation/sim_window.h"

#include <algorithm>
#include <array>

#include "tests/support/rooms.h"

namespace parray::simulation {

Time Resource::book(Time from, double seconds) {
  const double width = to_seconds(slot);
  double left = seconds;
  for (Time::rep number = from / slot;; ++number) {
    const double begins = std::max(0.0, to_seconds(from - number * slot));
    double& used = used_[number];
    const double taken = std::clamp(width - std::max(used, begins), 0.0, left);
    left -= taken;
    used += taken;
    if (left <= 0) return std::max(from + to_time(seconds), number * slot + to_time(used));
  }
}

void Resource::forget(Time before) { used_.erase(used_.begin(), used_.lower_bound(before / slot)); }

void SimMemory::settle(Time now) {
  put_lane_.forget(now);
  atomics_.forget(now);
  while (!later_.empty() && later_.top().at <= now) {
    const Write& write = later_.top();
    if (!dead(write.rank, write.at)) view_.put(write.offset, write.bytes);
    later_.pop();
  }
}

bool SimMemory::dead(std::uint32_t rank, Time at) const {
  return std::any_of(stops_.begin(), stops_.end(), [&](const Stop& stop) {
    return stop.rank == rank && stop.end == never && stop.begin <= at;
  });
}

Time SimMemory::reach_target(Time now) const {
  return link_.needs_target ? std::max(now, occupied_until_) : now;
}

Time SimMemory::atomic(std::uint32_t rank, Time now) {
  if (rank == owner_) return now + to_time(link_.own_atomic);
  return atomics_.book(reach_target(now), link_.atomic_service) +
         to_time(link_.atomic - link_.atomic_service);
}

Time SimMemory::put(std::uint32_t rank, Time now, std::size_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (rank == owner_) return now + to_time(size / link_.own_bytes_per_second);
  return put_lane_.book(reach_target(now), size / link_.bytes_per_second) + to_time(link_.put);
}

void SimMemory::write_later(Time at, std::uint32_t rank, std::size_t offset,
                            std::span<const std::byte> bytes) {
  later_.push({at, writes_++, rank, offset, {bytes.begin(), bytes.end()}});
}

std::uint64_t SimWindow::fetch_add(std::size_t word, std::uint64_t delta) {
  clock_.set(memory_.atomic(rank_, clock_.now()));
  return memory_.view().fetch_add(word, delta);
}

std::uint64_t SimWindow::load(std::size_t word) {
  clock_.set(memory_.atomic(rank_, clock_.now()));
  return memory_.view().load(word);
}

void SimWindow::store(std::size_t word, std::uint64_t value) {
  clock_.set(memory_.atomic(rank_, clock_.now()));
  const std::array words = {value};
  memory_.write_later(clock_.now(), rank_, word * sizeof value, std::as_bytes(std::span(words)));
}

void SimWindow::put(std::size_t offset, std::span<const std::byte> bytes) {
  clock_.advance(static_cast<double>(bytes.size()) / host_.digest_bytes_per_second);
  clock_.set(memory_.put(rank_, clock_.now(), bytes.size()));
  memory_.write_later(clock_.now(), rank_, offset, bytes);
}

}  // namespace parray::simulation
