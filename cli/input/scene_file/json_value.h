#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"

namespace parray::input {

enum class JsonKind : std::uint8_t { null, boolean, number, string, array, object };

/// Returns "a number", "an object" and so on, for messages.
std::string_view name_of(JsonKind kind);

struct JsonMember;

/// A JSON value with its line. Plain data. Members that its kind does not use are empty.
struct JsonValue {
  JsonKind kind = JsonKind::null;
  bool is_true = false;             ///< value of a boolean
  bool is_natural = false;          ///< a number of digits only, or -0, that fits `natural`
  std::uint64_t line = 0;           ///< line of its first character, from 1
  double number = 0;                ///< nearest double, finite
  std::uint64_t natural = 0;        ///< exact value if is_natural
  std::string text;                 ///< UTF-8, escapes resolved
  std::vector<JsonValue> items;     ///< items of an array
  std::vector<JsonMember> members;  ///< members of an object, in file order, with distinct keys
};

struct JsonMember {
  std::string key;
  std::uint64_t line = 0;  ///< line of the key
  JsonValue value;
};

/// Throws InputError "FILE:LINE: POINTER: PROBLEM". Makes all parts printable except `problem`. The
/// caller must build `problem` from printable parts.
[[noreturn]] void fail_at(std::string_view file, std::uint64_t line, std::string_view pointer,
                          std::string_view problem);

/// Returns `key` as a step of a JSON pointer (RFC 6901) with its leading slash. Shortens long keys.
std::string pointer_step(std::string_view key);

/// The place of a value in its document: a chain of keys and indices. It becomes text only in
/// messages. Refers to the name of the file, its parent and its key, which must outlive it.
class JsonPlace {
 public:
  /// The whole document. `file` names it in messages.
  explicit JsonPlace(const std::string& file) : file_(&file) {}

  JsonPlace at(std::string_view key) const { return {this, key, 0}; }
  JsonPlace at(std::size_t index) const { return {this, {}, index}; }

  /// Returns the pointer, such as "/camera/look_from/0". Returns "/" for the whole document.
  std::string pointer() const;

  /// Throws InputError "FILE:LINE: POINTER: PROBLEM".
  [[noreturn]] void fail(std::uint64_t line, std::string_view problem) const;

  /// Calls `work` and returns its result. If `work` throws InputError, throws it again by fail(),
  /// which adds this place.
  auto checked(std::uint64_t line, const auto& work) const {
    try {
      return work();
    } catch (const InputError& error) {
      fail(line, error.what());
    }
  }

 private:
  JsonPlace(const JsonPlace* parent, std::string_view key, std::size_t index)
      : file_(parent->file_), parent_(parent), key_(key), index_(index) {}

  const std::string* file_;
  const JsonPlace* parent_ = nullptr;
  std::string_view key_;  // data() == nullptr: the step is an index
  std::size_t index_ = 0;
};

}  // namespace parray::input
