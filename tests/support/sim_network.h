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

/// What a bad network does to a message, each with its probability.
struct Faults {
  double drop = 0;
  double repeat = 0;                     ///< delivered twice, at different times
  double truncate = 0;                   ///< a frame is cut short, or the last frame is lost
  Time longest_delay = milliseconds(1);  ///< uniform from 0: later messages may overtake
};

/// The machine of worker "w5"; two workers to each.
std::string machine_of(const PeerId& worker);
/// How other workers name it: by a port of that number.
PeerId outside_name(const PeerId& worker);
/// Inverse of outside_name().
PeerId inside_name(const PeerId& worker);

/// A network in virtual time, and the clock of everything attached to it. One coordinator's end;
/// any number of peers, of which "w" and a number names a worker that listens to others at a port
/// of that number. Deterministic for a seed.
class SimNetwork {
 public:
  SimNetwork(Faults faults, std::uint64_t seed) : faults_(faults), random_(seed) {}

  static constexpr const char* share_key = "key";

  struct Tally {
    std::uint64_t sent = 0;
    std::uint64_t dropped = 0;
    std::uint64_t repeated = 0;
    std::uint64_t truncated = 0;
    std::uint64_t overtaken = 0;  ///< delivered before an earlier message of the same sender
  };

  [[nodiscard]] Time now() const { return now_; }
  void advance_to(Time time) { now_ = std::max(now_, time); }
  /// When the next message arrives anywhere after now; `never` if none is on its way. What has
  /// arrived already may lie at the door of an end that is stopped.
  [[nodiscard]] Time next_arrival() const {
    const auto next = in_flight_.upper_bound(now_);
    return next == in_flight_.end() ? never : next->first;
  }
  [[nodiscard]] const Tally& tally() const { return tally_; }

  /// Sees every message as it is sent, before anything happens to it.
  std::function<void(const Frames&)> spy;

  /// The coordinator's end. Making it again drops what was waiting for the former one.
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
