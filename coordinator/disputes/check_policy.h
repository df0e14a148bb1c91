#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/rooms.h"

namespace parray::coordinator {

/// What is known of the machine, and the process, that a result came from.
struct CheckedWorker {
  std::uint64_t machine_leases = 0;  ///< accepted from its machine before, in this life
  std::uint64_t process_leases = 0;  ///< accepted since its process joined
  bool ours = false;                 ///< on the coordinator's machine, under its user: verified
};

/// Decides which leases are traced a second time, and by whom. Its random numbers decide nothing
/// about the bits of a picture. Plain state; one thread.
class CheckPolicy {
 public:
  struct Options {
    double share = 0;                   ///< of the leases, 0 to 1; 0: no checks at all
    bool ours_too = false;              ///< also those of workers of the coordinator's own user
    double first_share = 0.1;           ///< of a machine's first leases, unless `share` is more
    std::uint64_t first_leases = 100;   ///< of a machine
    std::uint64_t restart_leases = 20;  ///< of a process of it
    double referee_share = 0.1;         ///< of the checks, made by the referee
  };
  /// `random` returns numbers evenly in [0, 1). A faulty worker must not be able to foresee them.
  CheckPolicy(Options options, std::function<double()> random)
      : options_(options), random_(std::move(random)) {}

  /// The probability that the worker's lease is checked.
  [[nodiscard]] double share_of(const CheckedWorker& worker) const;
  /// Draws whether the worker's lease is checked.
  bool wants_check(const CheckedWorker& worker);
  /// Draws who checks, a place among so many machines; none: the referee.
  std::optional<std::size_t> draw_checker(std::size_t machines);
  /// Draws a whole number below `count`, which is above 0.
  std::uint64_t below(std::uint64_t count);

 private:
  const Options options_;
  std::function<double()> random_;
};

}  // namespace parray::coordinator
