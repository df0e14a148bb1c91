#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/scene/settings.h"

namespace parray::proto {

/// Settings as the map of PROTOCOL.md ("settings"), for messages and for what is kept on disk.
nlohmann::json settings_to_json(const RenderSettings& settings);

/// The settings that a report repeats, as they were asked for.
nlohmann::json settings_in_report(const RenderSettings& settings);

/// Inverse of settings_to_json(); every value is checked, nothing may be left automatic. Throws
/// ProtocolError.
RenderSettings settings_from_json(const nlohmann::json& map);

/// The unsigned integer `key` of a map, at most `most`. The library would convert any other number.
/// Throws ProtocolError that names the key.
std::uint64_t natural_in(const nlohmann::json& map, const char* key,
                         std::uint64_t most = UINT64_MAX);
/// A list of them; empty where the map has no such key.
std::vector<std::uint64_t> naturals_in(const nlohmann::json& map, const char* key);

}  // namespace parray::proto
