#pragma once

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

}  // namespace parray::http
