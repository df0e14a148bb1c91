#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/rooms.h"

namespace parray::http {

/// Of the reply that carries metrics_text().
inline constexpr const char* metrics_type = "text/plain; version=0.0.4; charset=utf-8";

/// A farm map of PROTOCOL.md, and what this process takes, for Prometheus: its text format 0.0.4,
/// with names as its guidelines have them (base units, _total for what only grows).
std::string metrics_text(const nlohmann::json& farm);

}  // namespace parray::http
