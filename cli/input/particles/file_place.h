#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/math/vec.h"

namespace parray::input {

/// The position of a reader in its file, for messages.
struct FilePlace {
  enum class Unit : std::uint8_t { whole_file, line, byte };

  std::string file;
  Unit unit = Unit::whole_file;
  std::uint64_t number = 0;  ///< a line from 1, or a byte from 0

  /// Throws InputError "FILE:LINE: PROBLEM", or "FILE: byte N: PROBLEM" in binary data. Makes the
  /// file's name printable; the caller makes `problem` printable.
  [[noreturn]] void fail(std::string_view problem) const;
};

/// Returns the number that `text` is; `what` names it. Fails at `place` if it is no finite number.
double number_field(std::string_view text, std::string_view what, const FilePlace& place);

/// Returns the numbers x, y and z in three words from `at` on.
Vec3d position_field(const std::vector<std::string_view>& words, std::size_t at,
                     const FilePlace& place);

/// Returns a number of particles from 0 to limits::max_spheres. Fails at `place` for other texts.
std::uint64_t count_field(std::string_view text, const FilePlace& place);

/// A file does not support what a member of a scene's item of `particles` asks for. The text gives
/// the problem. The caller adds the place: the scene file or the option.
class SourceError : public InputError {
 public:
  SourceError(std::string key, const std::string& problem)
      : InputError(problem), key_(std::move(key)) {}

  /// Key of the member in a scene file: "select", "color_by".
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace parray::input
