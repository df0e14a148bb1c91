#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "common/rooms.h"

namespace parray::http {

/// The media type of metrics_text().
inline constexpr const char* metrics_type = "text/plain; version=0.0.4; charset=utf-8";

/// Returns the metrics for Prometheus in its text format 0.0.4. `farm`: a farm map of PROTOCOL.md.
/// The metrics of this process are added. Names follow the guidelines of Prometheus: base units,
/// and _total for counters.
std::string metrics_text(const nlohmann::json& farm);

/// Counts answered requests by their status. Callable from any thread.
class RequestCounts {
 public:
  /// Counts an answer. Ignores a status outside 100 to 599.
  void add(int status);
  /// Returns the counts for Prometheus.
  [[nodiscard]] std::string metrics() const;

 private:
  static constexpr int least = 100;
  std::array<std::atomic<std::uint64_t>, 500> counts_{};  ///< from status `least` on
};

}  // namespace parray::http
