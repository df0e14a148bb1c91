#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

enum class JsonKind : std::uint8_t { null, boolean, number, string, array, object };

/// "a number", "an object", ... for messages.
std::string_view name_of(JsonKind kind);

struct JsonMember;

/// A JSON value that knows where it stands. Plain data; what its kind does not use is empty.
struct JsonValue {
  JsonKind kind = JsonKind::null;
  bool is_true = false;             ///< a boolean's value
  bool is_natural = false;          ///< a number written in digits alone that fits `natural`
  std::uint64_t line = 0;           ///< of its first character, counted from 1
  double number = 0;                ///< nearest double, finite
  std::uint64_t natural = 0;        ///< exact, where is_natural
  std::string text;                 ///< UTF-8, escapes resolved
  std::vector<JsonValue> items;     ///< of an array
  std::vector<JsonMember> members;  ///< of an object, in file order, keys distinct
};

struct JsonMember {
  std::string key;
  std::uint64_t line = 0;  ///< of the key
  JsonValue value;
};

/// Throws InputError "FILE:LINE: POINTER: PROBLEM", all of it made printable except `problem`,
/// which the caller builds from printable parts.
[[noreturn]] void fail_at(std::string_view file, std::uint64_t line, std::string_view pointer,
                          std::string_view problem);

/// `key` as a JSON pointer writes it (RFC 6901), with its leading slash; long ones are cut.
std::string pointer_step(std::string_view key);

/// Where a value stands in its document: a chain of keys and indices, spelt out only when a
/// message needs it. Refers to its parent and its key, which must outlive it.
class JsonPlace {
 public:
  /// The whole document; `file` names it in messages.
  explicit JsonPlace(const std::string& file) : file_(&file) {}

  JsonPlace at(std::string_view key) const { return {this, key, 0}; }
  JsonPlace at(std::size_t index) const { return {this, {}, index}; }

  /// "/camera/look_from/0"; "/" for the whole document.
  std::string pointer() const;

  /// Throws InputError "FILE:LINE: POINTER: PROBLEM".
  [[noreturn]] void fail(std::uint64_t line, std::string_view problem) const;

 private:
  JsonPlace(const JsonPlace* parent, std::string_view key, std::size_t index)
      : file_(parent->file_), parent_(parent), key_(key), index_(index) {}

  const std::string* file_;
  const JsonPlace* parent_ = nullptr;
  std::string_view key_;  // data() is null: an index
  std::size_t index_ = 0;
};

}  // namespace parray::input
