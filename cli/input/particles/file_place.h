#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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
  std::uint64_t number = 0;  ///< a line from 1, or a byte from 0; unused for `whole_file`

  /// Throws InputError at this place: "FILE:LINE: PROBLEM" for a line, "FILE: byte N: PROBLEM" for
  /// a byte, and "FILE: PROBLEM" for the whole file. Makes the file's name printable; the caller
  /// makes `problem` printable.
  [[noreturn]] void fail(std::string_view problem) const;
  /// Like fail(). fail_damaged() adds that the file is probably damaged. fail_incomplete() adds
  /// that the user should check that the file is complete.
  [[noreturn]] void fail_damaged(std::string_view problem) const;
  [[noreturn]] void fail_incomplete(std::string_view problem) const;
};

/// Parses a number. `what` names the number in the message. Throws InputError at `place` for other
/// texts and for numbers that are not finite.
double number_field(std::string_view text, std::string_view what, const FilePlace& place);

/// Parses x, y and z in the three words from `at` on, like number_field(). `words` must contain
/// them.
Vec3d position_field(const std::vector<std::string_view>& words, std::size_t at,
                     const FilePlace& place);

/// Parses a number of particles from 0 to limits::max_shapes. Throws InputError at `place` for
/// other texts.
std::uint64_t count_field(std::string_view text, const FilePlace& place);

/// Error: a member of an item of `particles` in a scene file, or its option, does not suit the
/// particle file. For example, the file lacks the column that "color_by" names, or "select" leaves
/// no particle. The text gives the problem. The caller adds the place: the scene file or the
/// option.
class SourceError : public InputError {
 public:
  SourceError(std::string key, const std::string& problem,
              std::optional<std::size_t> representation = {})
      : InputError(problem), key_(std::move(key)), representation_(representation) {}

  /// Returns the key of the member in a scene file: "select", "color_by".
  [[nodiscard]] const std::string& key() const { return key_; }
  /// Number of the representation to which the member belongs, from 0. Nothing: a member of the
  /// item itself.
  [[nodiscard]] const std::optional<std::size_t>& representation() const { return representation_; }

 private:
  std::string key_;
  std::optional<std::size_t> representation_;
};

}  // namespace parray::input
