#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "proto/link.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Faults of a network, each with its probability per message.
struct Faults {
  double drop = 0;
  double repeat = 0;    ///< the message arrives twice, at different times
  double truncate = 0;  ///< a frame is truncated, or the last frame is lost
  Time longest_delay =
      milliseconds(1);  ///< delays are uniform from 0, so messages may overtake each other
};

/// Returns the machine of a worker such as "w5". Each machine has two workers.
std::string machine_of(const PeerId& worker);
/// Returns the address of a worker for other workers: a port of its number.
PeerId outside_name(const PeerId& worker);
/// Inverse of outside_name().
PeerId inside_name(const PeerId& worker);

/// A network in virtual time, and the clock of everything attached to it. It has one coordinator
/// and any number of peers. A peer whose name is "w" and a number is a worker. It listens to other
/// workers at the port with that number. The same seed gives the same events.
class SimNetwork {
 public:
  SimNetwork(Faults faults, std::uint64_t seed) : faults_(faults), random_(seed) {}

  static constexpr const char* share_key = "key";

  struct Tally {
    std::uint64_t sent = 0;
    std::uint64_t dropped = 0;
    std::uint64_t repeated = 0;
    std::uint64_t truncated = 0;
    std::uint64_t overtaken =
        0;  ///< messages that arrived before an earlier message of the same sender
  };

  [[nodiscard]] Time now() const { return now_; }
  void advance_to(Time time) { now_ = std::max(now_, time); }
  /// Returns the time when the next message arrives anywhere; `never` if none is in flight.
  /// Messages that have arrived at a stopped peer do not count.
  [[nodiscard]] Time next_arrival() const {
    const auto next = in_flight_.upper_bound(now_);
    return next == in_flight_.end() ? never : next->first;
  }
  [[nodiscard]] const Tally& tally() const { return tally_; }

  /// Called with every message when it is sent, before any fault.
  std::function<void(const Frames&)> spy;

  /// Makes the coordinator's end of the network. Drops messages that wait for an earlier
  /// coordinator.
  std::unique_ptr<Link> coordinator_end();
  std::unique_ptr<Link> peer_end(const PeerId& id);

 private:
  class End;
  struct Flight {
    PeerId from;
    PeerId to;
    std::uint64_t number;
    Frames frames;
  };

  bool chance(double probability) {
    return std::uniform_real_distribution<>(0, 1)(random_) < probability;
  }
  void post(const PeerId& from, const PeerId& to, Frames frames);
  void launch(const PeerId& from, const PeerId& to, Frames frames);
  std::optional<Delivery> arrived(const PeerId& at);

  Faults faults_;
  std::mt19937_64 random_;
  Time now_{0};
  std::uint64_t next_number_ = 0;
  std::multimap<Time, Flight> in_flight_;
  std::map<PeerId, std::uint64_t> last_number_;
  Tally tally_;
};

}  // namespace parray::test
