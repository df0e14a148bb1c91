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

/// Returns JSON as the text of an indented document, with a newline at its end. Also replaces bytes
/// that are not UTF-8.
inline std::string json_document(const nlohmann::json& value) {
  return value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace parray::base
