#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/rooms.h"

namespace parray::coordinator {

/// What is known about the machine and the process that returned a result.
struct CheckedWorker {
  std::uint64_t machine_leases = 0;  ///< accepted from its machine in this process before
  std::uint64_t process_leases = 0;  ///< accepted since its process joined
  bool ours = false;                 ///< on the coordinator's machine, under its user: verified
};

/// Decides which leases are checked, and by which machine. Its random numbers do not influence the
/// bits of a picture. Not thread-safe.
class CheckPolicy {
 public:
  struct Options {
    double share = 0;                   ///< share of the leases to check, 0 to 1; 0: none
    bool ours_too = false;              ///< also check workers of the coordinator's own user
    double first_share = 0.1;           ///< share of the first leases, unless `share` is larger
    std::uint64_t first_leases = 100;   ///< number of first leases of a machine
    std::uint64_t restart_leases = 20;  ///< number of first leases of a process
    double referee_share = 0.1;         ///< share of the checks that the referee makes
  };
  /// `random` returns uniform numbers in [0, 1). Workers must not be able to predict them.
  CheckPolicy(Options options, std::function<double()> random)
      : options_(options), random_(std::move(random)) {}

  /// Returns the probability that the worker's lease is checked.
  [[nodiscard]] double share_of(const CheckedWorker& worker) const;
  /// Draws whether the worker's lease is checked.
  bool wants_check(const CheckedWorker& worker);
  /// Draws the machine that checks: an index below `machines`. Nothing: the referee checks.
  std::optional<std::size_t> draw_checker(std::size_t machines);
  /// Draws an integer from 0 to `count` - 1. `count` must be above 0.
  std::uint64_t below(std::uint64_t count);

 private:
  const Options options_;
  std::function<double()> random_;
};

}  // namespace parray::coordinator
