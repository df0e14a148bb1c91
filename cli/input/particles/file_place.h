#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Where a reader stands in its file, for messages.
struct FilePlace {
  enum class Unit : std::uint8_t { whole_file, line, byte };

  std::string file;
  Unit unit = Unit::whole_file;
  std::uint64_t number = 0;  ///< a line from 1, or a byte from 0

  /// Throws InputError "FILE:LINE: PROBLEM" ("FILE: byte N: PROBLEM" in binary data). The file's
  /// name is made printable here, the problem by the caller.
  [[noreturn]] void fail(std::string_view problem) const;
};

}  // namespace parray::input
