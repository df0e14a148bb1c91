#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/error.h"

namespace parray {

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

/// The number of a field; `what` names it. Fails at `place` when it is not one, or not finite.
double number_field(std::string_view text, std::string_view what, const FilePlace& place);

/// The number of particles that a file announces, 0 to limits::max_spheres.
std::uint64_t count_field(std::string_view text, const FilePlace& place);

/// A member of an item of `particles` asks for what its file cannot give. The text says what, not
/// where: whoever knows the scene file or the option adds that.
class SourceError : public InputError {
 public:
  SourceError(std::string key, const std::string& problem)
      : InputError(problem), key_(std::move(key)) {}

  /// "select", "color_by": the member's key in a scene file.
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace parray
