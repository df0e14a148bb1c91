#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/math/vec.h"
#include "common/scene/limits.h"

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

/// Each function reads `value`, which is at `place`, as the type in its name. Otherwise it throws
/// InputError with the expected type or range.
/// A negative zero becomes zero, so that equal scenes have equal bytes.
double read_number(const JsonValue& value, const JsonPlace& place, NumberRange range);
/// Accepts 100, 100.0 and 1e2. Beyond 2^53, where doubles skip integers, accepts only digits.
std::uint64_t read_integer(const JsonValue& value, const JsonPlace& place, IntegerRange range);
const std::string& read_string(const JsonValue& value, const JsonPlace& place);

/// Throws InputError: the key `key` on `line` of the object at `object` is not in `known`.
[[noreturn]] void fail_unknown_key(std::string_view key, std::uint64_t line,
                                   const JsonPlace& object,
                                   std::span<const std::string_view> known);

/// Throws InputError: the object that starts on `line` lacks `key`. `expectation` describes its
/// value and follows "add": "true or false".
[[noreturn]] void fail_missing_key(std::string_view key, std::uint64_t line,
                                   const JsonPlace& object, std::string_view expectation);

/// Reads the members of an object by key. Refers to the value and its place, which must outlive
/// this object. The readers throw InputError for a missing key.
class JsonFields {
 public:
  /// Throws InputError unless `value` is an object whose keys are all in `known`.
  JsonFields(const JsonValue& value, const JsonPlace& place,
             std::span<const std::string_view> known);
  JsonFields(const JsonValue& value, const JsonPlace& place,
             std::initializer_list<std::string_view> known)
      : JsonFields(value, place, std::span(known.begin(), known.size())) {}

  /// Returns the value of a key. Returns nullptr if the object has no such key.
  const JsonValue* find(std::string_view key) const;
  std::uint64_t line() const { return value_.line; }
  const JsonPlace& place() const { return place_; }

  /// Returns the value of a required key. `expectation` describes it as in fail_missing_key().
  const JsonValue& any(std::string_view key, std::string_view expectation) const;
  // Read the value of a required key by read_number() and so on.
  double number(std::string_view key, NumberRange range) const;
  /// Reads an array of three numbers, each in `range`.
  Vec3d vec3(std::string_view key, NumberRange range) const;
  const std::string& string(std::string_view key) const;
  bool boolean(std::string_view key) const;
  std::uint64_t integer(std::string_view key, IntegerRange range) const;

 private:
  const JsonValue& value_;
  const JsonPlace& place_;
};

}  // namespace parray::input
