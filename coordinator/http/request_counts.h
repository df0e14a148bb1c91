#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "common/rooms.h"

namespace parray::http {

/// Counts answered requests by their status. Callable from any thread.
class RequestCounts {
 public:
  /// Counts an answer. Ignores a status outside 100 to 599.
  void add(int status);
  /// Returns the counts for Prometheus, as metrics_text() does.
  [[nodiscard]] std::string metrics() const;

 private:
  static constexpr int least = 100;
  std::array<std::atomic<std::uint64_t>, 500> counts_{};  ///< from status `least` on
};

}  // namespace parray::http
