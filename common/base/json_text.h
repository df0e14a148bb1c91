#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// Returns JSON as text in one line. Replaces bytes that are not UTF-8, so that it never fails.
/// `ascii`: escapes all other characters.
template <typename Json = nlohmann::json>
std::string json_text(const Json& value, bool ascii = false) {
  return value.dump(-1, ' ', ascii, Json::error_handler_t::replace);
}

}  // namespace parray::base
