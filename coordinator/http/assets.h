#pragma once

#include <span>
#include <string_view>

#include "common/rooms.h"

namespace parray::http {

/// A file that the program has in it: made of those in page/ by embed.cmake.
struct Asset {
  std::string_view path;  ///< where it is served: "/" for index.html
  std::string_view type;
  std::string_view bytes;
};

std::span<const Asset> assets();

}  // namespace parray::http
