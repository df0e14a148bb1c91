#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "proto/clock.h"

namespace parray::http {

/// Limits the bytes that are held at the same time. If nothing else is held, a request of any size
/// succeeds, so that large items are possible. Callable from any thread. Must outlive its Holds.
class Budget {
 public:
  /// `most`: the limit in bytes.
  explicit Budget(std::uint64_t most) : most_(most) {}
  Budget& operator=(Budget&&) = delete;

  /// Holds bytes of the budget until its last copy is destroyed.
  using Hold = std::shared_ptr<const void>;

  /// Waits up to `patience` until `bytes` are free. Throws Problem 503 if they are not. `what`:
  /// what the bytes are for, in the message "the server has no room for `what` now": "another
  /// picture".
  Hold hold(std::uint64_t bytes, Time patience, const std::string& what);

 private:
  const std::uint64_t most_;
  std::mutex mutex_;  // guards the fields below
  std::condition_variable changed_;
  std::uint64_t held_ = 0;
};

}  // namespace parray::http
