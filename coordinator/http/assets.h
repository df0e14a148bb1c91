#pragma once

#include <span>
#include <string_view>

#include "common/rooms.h"

namespace parray::http {

/// A file of page/, or openapi.json, that embed.cmake compiled into the program.
struct Asset {
  std::string_view path;  ///< URL path; "/" for index.html
  std::string_view type;  ///< media type
  std::string_view bytes;
};

/// Returns all embedded files.
std::span<const Asset> assets();

}  // namespace parray::http
