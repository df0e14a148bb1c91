#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/scene/settings_fwd.h"

namespace parray::proto {

/// Returns settings as the map of PROTOCOL.md ("settings"), for messages and for files.
nlohmann::json settings_to_json(const RenderSettings& settings);

/// Returns the settings that a report repeats: their resolved values, under the same keys.
nlohmann::json settings_in_report(const RenderSettings& settings);

/// Reads the map of settings_to_json(). Checks every value; none but `isa` may be automatic. Throws
/// ProtocolError.
Boxed<RenderSettings> settings_from_json(const nlohmann::json& map);

/// Returns the unsigned integer `key` of a map, at most `most`. (The library itself would convert
/// any other number.) Throws ProtocolError with the name of the key.
std::uint64_t natural_in(const nlohmann::json& map, const char* key,
                         std::uint64_t most = UINT64_MAX);
/// Returns a list of unsigned integers; empty if the map has no such key. Throws ProtocolError.
std::vector<std::uint64_t> naturals_in(const nlohmann::json& map, const char* key);

}  // namespace parray::proto
