#pragma once

#include <nlohmann/json.hpp>

#include "common/scene/settings.h"

namespace parray {

/// Settings as the map of PROTOCOL.md ("settings"), for messages and for what is kept on disk.
nlohmann::json settings_to_json(const RenderSettings& settings);

/// Inverse; every value is checked, nothing may be left automatic. Throws ProtocolError.
RenderSettings settings_from_json(const nlohmann::json& map);

}  // namespace parray
