#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <queue>
#include <span>
#include <vector>

#include "proto/clock.h"
#include "proto/window.h"
#include "tests/experiments/simulation/costs.h"
#include "tests/support/rooms.h"

namespace parray::simulation {

inline Time to_time(double seconds) { return from_seconds(seconds); }

/// A rank's own time: operations move it on.
class RankClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override { return now_; }
  void set(Time now) { now_ = now; }
  void advance(double seconds) { now_ += to_time(seconds); }

 private:
  Time now_{};
};

/// A time in which a rank does nothing; to `never`: it has died.
struct Stop {
  std::uint32_t rank = 0;
  Time begin{};
  Time end = never;
};

/// Something that serves one at a time, booked in any order: turns are simulated one after the
/// other, although they overlap.
class Resource {
 public:
  /// Books `seconds` of it at `from` or later; returns when they are over. Nothing will be booked
  /// before forget()'s time.
  Time book(Time from, double seconds);
  void forget(Time before);

 private:
  static constexpr Time slot = std::chrono::microseconds(20);
  std::map<Time::rep, double> used_;  ///< seconds of each slot that is not free
};

/// A rank's memory and the link to it, which all ranks share.
///
/// A rank's turn is simulated at once: what it reads is what was there when the turn began, what it
/// writes is there when the operation would be complete. A turn takes some microseconds.
class SimMemory {
 public:
  SimMemory(std::span<std::byte> memory, const LinkCosts& link, std::span<const Stop> stops,
            std::uint32_t owner = 0)
      : memory_(memory), view_(memory), link_(link), stops_(stops), owner_(owner) {}

  /// Makes everything visible that is complete by `now`.
  void settle(Time now);
  /// The owner's thread does something else until then.
  void occupy(Time until) { occupied_until_ = until; }

  /// When an atomic operation of `rank`, begun at `now`, is complete.
  Time atomic(std::uint32_t rank, Time now);
  /// When a put is.
  Time put(std::uint32_t rank, Time now, std::size_t bytes);

  LocalWindow& view() { return view_; }
  void write_later(Time at, std::uint32_t rank, std::size_t offset,
                   std::span<const std::byte> bytes);

 private:
  struct Write {
    Time at;
    std::uint64_t order;
    std::uint32_t rank;
    std::size_t offset;
    std::vector<std::byte> bytes;
    bool operator>(const Write& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };
  [[nodiscard]] bool dead(std::uint32_t rank, Time at) const;
  [[nodiscard]] Time reach_target(Time now) const;

  std::span<std::byte> memory_;
  LocalWindow view_;
  const LinkCosts& link_;
  std::span<const Stop> stops_;
  const std::uint32_t owner_;
  Resource put_lane_;
  Resource atomics_;
  Time occupied_until_{};
  std::uint64_t writes_ = 0;
  std::priority_queue<Write, std::vector<Write>, std::greater<>> later_;
};

/// The window as one rank sees it: charges the rank's clock.
class SimWindow final : public Window {
 public:
  SimWindow(SimMemory& memory, std::uint32_t rank, RankClock& clock, const HostCosts& host)
      : memory_(memory), rank_(rank), clock_(clock), host_(host) {}

  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  SimMemory& memory_;
  const std::uint32_t rank_;
  RankClock& clock_;
  const HostCosts& host_;
};

}  // namespace parray::simulation
