#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "common/base/error.h"
#include "common/scene/limits.h"
#include "proto/clock.h"
#include "proto/link.h"

namespace parray::coordinator {

/// Limits of a coordinator and of each user. Frames of one series count as one job.
struct Limits {
  /// All jobs, also ended ones. At this limit a new job deletes the oldest ended job.
  std::size_t jobs = 1000;
  std::size_t user_jobs = 200;                        ///< unfinished jobs of one user
  std::size_t pixels = limits::max_pixels;            ///< pixels of one picture
  std::size_t user_pixels = std::size_t{1} << 30;     ///< pixels of one user's unfinished jobs
  std::uint64_t disk = std::uint64_t{100} << 30;      ///< bytes of the store
  std::uint64_t user_disk = std::uint64_t{50} << 30;  ///< bytes of one user's jobs in the store
  double keep_lost_seconds = 30.0 * 24 * 3600;  ///< uptime after which a file in lost/ is deleted
  double keep_seconds = 90.0 * 24 * 3600;       ///< uptime for which a job is kept after its end
  std::size_t requests = 1000;  ///< messages per second from a peer that is not a worker
};

/// Error: there is no room for a job now, but there may be room later.
class NoRoom : public InputError {
 public:
  using InputError::InputError;
};

/// Limits the messages per second of each peer that is not a worker.
class RequestBudget {
 public:
  /// `most`: messages per second and peer.
  explicit RequestBudget(std::size_t most) : most_(most) {}

  /// Counts a message of this peer. Returns whether the coordinator should read it.
  bool allow(Time now, const PeerId& peer) {
    if (now - began_ >= seconds(1)) {
      began_ = now;
      counts_.clear();
    }
    return ++counts_[peer] <= most_;
  }

 private:
  std::size_t most_;
  Time began_{};
  std::map<PeerId, std::size_t> counts_;  ///< messages since began_
};

}  // namespace parray::coordinator
