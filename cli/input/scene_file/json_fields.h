#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cli/input/scene_file/json_value.h"
#include "common/math/vec.h"
#include "common/scene/limits.h"

namespace parray::input {

/// Each function reads `value`, which is at `place`, as the type in its name. Otherwise it throws
/// InputError with the expected type or range.
/// A negative zero becomes zero, so that equal scenes have equal bytes.
double read_number(const JsonValue& value, const JsonPlace& place, NumberRange range);
/// Accepts 100, 100.0 and 1e2. Beyond 2^53, where doubles skip integers, accepts only digits.
std::uint64_t read_integer(const JsonValue& value, const JsonPlace& place, IntegerRange range);
/// Reads an array of three numbers, each in `range`.
Vec3d read_vec3(const JsonValue& value, const JsonPlace& place, NumberRange range);
const std::string& read_string(const JsonValue& value, const JsonPlace& place);
bool read_boolean(const JsonValue& value, const JsonPlace& place);

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

  /// Returns the value of a key. Returns nullptr if the object has no such key.
  const JsonValue* find(std::string_view key) const;
  std::uint64_t line() const { return value_.line; }
  const JsonPlace& place() const { return place_; }

  /// Returns the value of a required key. `expectation` describes it as in fail_missing_key().
  const JsonValue& any(std::string_view key, std::string_view expectation) const;
  // Read the value of a required key by read_number(), read_vec3() and so on.
  double number(std::string_view key, NumberRange range) const;
  Vec3d vec3(std::string_view key, NumberRange range) const;
  const std::string& string(std::string_view key) const;
  bool boolean(std::string_view key) const;
  std::uint64_t integer(std::string_view key, IntegerRange range) const;

 private:
  const JsonValue& value_;
  const JsonPlace& place_;
};

}  // namespace parray::input
