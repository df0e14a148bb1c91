#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "proto/clock.h"

namespace parray::http {

/// Bytes that may be held at once. Who holds nothing beside it may hold any number: else something
/// large could never be had. Any thread.
class Budget {
 public:
  explicit Budget(std::uint64_t most) : most_(most) {}
  Budget(const Budget&) = delete;
  Budget& operator=(const Budget&) = delete;

  /// Bytes that are held, while this lives.
  class Hold {
   public:
    Hold(Budget& budget, std::uint64_t bytes) : budget_(&budget), bytes_(bytes) {}
    ~Hold();
    Hold(Hold&& other) noexcept;
    Hold& operator=(Hold&&) = delete;
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;

   private:
    Budget* budget_;
    std::uint64_t bytes_;
  };

  /// None: there is no room now.
  std::optional<Hold> try_hold(std::uint64_t bytes);
  /// Waits `patience` for room. Throws Problem 503 that names `what`.
  Hold hold(std::uint64_t bytes, Time patience, const std::string& what);
  [[nodiscard]] std::uint64_t held();

 private:
  [[nodiscard]] bool has_room(std::uint64_t bytes) const;
  void give_back(std::uint64_t bytes);

  const std::uint64_t most_;
  std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  std::uint64_t held_ = 0;
};

}  // namespace parray::http
