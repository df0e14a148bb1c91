#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
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

  /// Holds bytes of the budget during its lifetime. Made by hold().
  class Hold {
   public:
    ~Hold();
    Hold(Hold&& other) noexcept;
    Hold& operator=(Hold&&) = delete;

   private:
    friend Budget;
    Hold(Budget& budget, std::uint64_t bytes) : budget_(&budget), bytes_(bytes) {}

    Budget* budget_;
    std::uint64_t bytes_;
  };

  /// Waits up to `patience` until `bytes` are free. Throws Problem 503 if they are not. `what`:
  /// what the bytes are for, in the message "the server has no room for `what` now": "another
  /// picture".
  Hold hold(std::uint64_t bytes, Time patience, const std::string& what);

 private:
  [[nodiscard]] bool has_room(std::uint64_t bytes) const;
  void give_back(std::uint64_t bytes);

  const std::uint64_t most_;
  std::mutex mutex_;  // guards the fields below
  std::condition_variable changed_;
  std::uint64_t held_ = 0;
};

}  // namespace parray::http
