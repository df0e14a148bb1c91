#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "common/rooms.h"

namespace parray::coordinator {

/// What is known about the machine and the process that returned a result: the results of
/// little-known workers are checked more often.
struct CheckedWorker {
  /// Leases accepted from its machine since the coordinator started.
  std::uint64_t machine_leases = 0;
  std::uint64_t process_leases = 0;  ///< leases accepted from its process since it joined
  /// The kernel says that the process runs on the coordinator's machine, as the coordinator's user.
  bool ours = false;
};

/// Decides which leases are checked (traced again by another machine), and by which machine. Its
/// random numbers do not influence the bits of a picture. Not thread-safe.
class CheckPolicy {
 public:
  struct Options {
    /// Share of the leases to check, 0 to 1; 0: no checks at all.
    double share = 0;
    bool ours_too = false;  ///< also check workers of the coordinator's own user
    /// Share of the first leases to check, unless `share` is larger.
    double first_share = 0.1;
    std::uint64_t first_leases = 100;   ///< number of leases of a machine that count as first
    std::uint64_t restart_leases = 20;  ///< number of leases of a new process that count as first
    /// Share of the checks in which the referee checks some of the cells, too.
    double referee_share = 0.1;
    /// Spheres and capsules of the largest scene that the referee checks if other machines can. For
    /// a larger scene it would need seconds to build the accelerator.
    std::uint64_t most_spheres = 2'000'000;
  };
  /// `random` returns uniform numbers in [0, 1). Workers must not be able to predict them.
  CheckPolicy(Options options, std::function<double()> random)
      : options_(options), random_(std::move(random)) {}

  /// Returns the probability that the worker's lease is checked.
  [[nodiscard]] double share_of(const CheckedWorker& worker) const {
    if (options_.share <= 0 || (worker.ours && !options_.ours_too)) return 0;
    const bool fresh = worker.machine_leases < options_.first_leases ||
                       worker.process_leases < options_.restart_leases;
    return fresh ? std::max(options_.share, options_.first_share) : options_.share;
  }
  /// Draws whether the worker's lease is checked.
  bool wants_check(const CheckedWorker& worker) {
    const double share = share_of(worker);
    return share > 0 && random_() < share;
  }
  /// Draws which of `machines` machines makes a check: returns its index, from 0. Nothing: the
  /// referee checks some of the cells, too (the caller then draws the machine by below()), or
  /// `machines` is 0.
  std::optional<std::size_t> draw_checker(std::size_t machines) {
    if (machines == 0 || random_() < options_.referee_share) return {};
    return below(machines);
  }
  /// Returns whether every lease must be checked.
  [[nodiscard]] bool checks_all() const { return options_.share >= 1; }
  /// Draws an integer from 0 to `count` - 1. `count` must be above 0.
  std::uint64_t below(std::uint64_t count) {
    const auto drawn = static_cast<std::uint64_t>(random_() * static_cast<double>(count));
    return std::min(drawn, count - 1);
  }

 private:
  const Options options_;
  std::function<double()> random_;
};

}  // namespace parray::coordinator
