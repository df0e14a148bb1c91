#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "common/base/error.h"
#include "proto/clock.h"
#include "proto/link.h"

namespace parray::coordinator {

/// What a coordinator takes, in all and of each user. Frames of one series count as one job.
struct Limits {
  std::size_t jobs = 1000;                         ///< kept; the oldest that has ended makes room
  std::size_t user_jobs = 200;                     ///< unfinished, of one user
  std::size_t pixels = std::size_t{1} << 28;       ///< of a picture
  std::size_t user_pixels = std::size_t{1} << 30;  ///< of the unfinished jobs of one user
  std::uint64_t disk = std::uint64_t{100} << 30;   ///< bytes of the store
  std::uint64_t user_disk = std::uint64_t{50} << 30;  ///< likewise, of one user
  double keep_lost_seconds = 30.0 * 24 * 3600;        ///< that files which were set aside are kept
  double keep_seconds = 90.0 * 24 * 3600;             ///< since it ended, that a job is kept
  std::size_t requests = 1000;  ///< messages a second of one peer that is no worker
};

/// There is no room now; later there may be.
class NoRoom : public InputError {
 public:
  using InputError::InputError;
};

/// Messages of peers that are no workers: so many a second each.
class RequestBudget {
 public:
  explicit RequestBudget(std::size_t most) : most_(most) {}

  /// Whether one more of this peer is to be read.
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
  std::map<PeerId, std::size_t> counts_;  ///< since then
};

}  // namespace parray::coordinator
