#include "cli/input/scene_file/json_value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::input {
namespace {

std::string text_of(NumberRange range) {
  return "a number from " + number_text(range.least) + " to " + number_text(range.most);
}

std::string text_of(IntegerRange range) {
  return "a whole number from " + std::to_string(range.least) + " to " + std::to_string(range.most);
}

std::string text_of_vec3(NumberRange range) {
  return "an array of three numbers from " + number_text(range.least) + " to " +
         number_text(range.most);
}

/// Throws InputError with the text remedy() unless `value` is of this kind.
void expect(JsonKind kind, const JsonValue& value, const JsonPlace& place, const auto& remedy) {
  if (value.kind == kind) return;
  place.fail(value.line, "expected " + std::string(name_of(kind)) + ", found " +
                             std::string(name_of(value.kind)) + ": " + remedy());
}

/// Returns the exact value of a natural number. Returns nothing for other numbers, and if the value
/// may differ from the one in the file.
std::optional<std::uint64_t> natural_in(const JsonValue& value) {
  constexpr double exact_integers = 9007199254740992.0;  // 2^53
  if (value.is_natural) return value.natural;
  const double number = value.number;
  if (number < 0 || number > exact_integers || number != std::floor(number)) return {};
  return static_cast<std::uint64_t>(number);
}

}  // namespace

std::string_view name_of(JsonKind kind) {
  constexpr std::array<std::string_view, 6> names{"null",     "a boolean", "a number",
                                                  "a string", "an array",  "an object"};
  return names.at(static_cast<std::size_t>(kind));
}

void fail_at(std::string_view file, std::uint64_t line, std::string_view pointer,
             std::string_view problem) {
  constexpr std::size_t longest_path = 4096;
  std::string message = printable(file, longest_path) + ":" + std::to_string(line) + ": ";
  message.append(pointer.empty() ? "/" : pointer).append(": ").append(problem);
  throw InputError(message);
}

std::string pointer_step(std::string_view key) {
  std::string out = "/";
  for (const char c : printable(key, 40)) {
    if (c == '~') {
      out += "~0";
    } else if (c == '/') {
      out += "~1";
    } else {
      out += c;
    }
  }
  return out;
}

std::string JsonPlace::pointer() const {
  if (parent_ == nullptr) return "/";
  const std::string above = parent_->parent_ == nullptr ? "" : parent_->pointer();
  const bool is_index = key_.data() == nullptr;
  return above + (is_index ? "/" + std::to_string(index_) : pointer_step(key_));
}

void JsonPlace::fail(std::uint64_t line, std::string_view problem) const {
  fail_at(*file_, line, pointer(), problem);
}

double read_number(const JsonValue& value, const JsonPlace& place, NumberRange range) {
  expect(JsonKind::number, value, place, [&] { return "write " + text_of(range); });
  if (value.number < range.least || value.number > range.most) {
    place.fail(value.line, number_text(value.number) + " is out of range: use " + text_of(range));
  }
  return value.number + 0.0;  // -0 + 0 is +0
}

std::uint64_t read_integer(const JsonValue& value, const JsonPlace& place, IntegerRange range) {
  expect(JsonKind::number, value, place, [&] { return "write " + text_of(range); });
  const std::optional<std::uint64_t> natural = natural_in(value);
  if (natural && *natural >= range.least && *natural <= range.most) return *natural;
  const bool is_whole = natural || value.number == std::floor(value.number);
  place.fail(value.line, (natural ? std::to_string(*natural) : number_text(value.number)) +
                             (is_whole ? " is out of range" : " is not a whole number") + ": use " +
                             text_of(range));
}

const std::string& read_string(const JsonValue& value, const JsonPlace& place) {
  expect(JsonKind::string, value, place, [&] { return "write a text in double quotes"; });
  return value.text;
}

void fail_unknown_key(std::string_view key, std::uint64_t line, const JsonPlace& object,
                      std::span<const std::string_view> known) {
  const std::string pointer = object.pointer();
  object.at(key).fail(line, "unknown key '" + printable(key) + "' " +
                                (pointer == "/" ? "at the top level" : "in " + pointer) + ": " +
                                remedy_for_name(key, known));
}

void fail_missing_key(std::string_view key, std::uint64_t line, const JsonPlace& object,
                      std::string_view expectation) {
  object.fail(line, "missing key '" + std::string(key) + "': add " + std::string(expectation));
}

JsonFields::JsonFields(const JsonValue& value, const JsonPlace& place,
                       std::span<const std::string_view> known)
    : value_(value), place_(place) {
  expect(JsonKind::object, value, place, [&] { return "write { ... } with " + list_names(known); });
  for (const JsonMember& member : value.members) {
    if (std::ranges::find(known, member.key) == known.end()) {
      fail_unknown_key(member.key, member.line, place, known);
    }
  }
}

const JsonValue* JsonFields::find(std::string_view key) const {
  const auto found = std::ranges::find(value_.members, key, &JsonMember::key);
  return found == value_.members.end() ? nullptr : &found->value;
}

const JsonValue& JsonFields::any(std::string_view key, std::string_view expectation) const {
  const JsonValue* found = find(key);
  if (found == nullptr) fail_missing_key(key, line(), place_, expectation);
  return *found;
}

double JsonFields::number(std::string_view key, NumberRange range) const {
  return read_number(any(key, text_of(range)), place_.at(key), range);
}

Vec3d JsonFields::vec3(std::string_view key, NumberRange range) const {
  const JsonValue& value = any(key, text_of_vec3(range));
  const JsonPlace place = place_.at(key);
  expect(JsonKind::array, value, place, [&] { return "write " + text_of_vec3(range); });
  if (value.items.size() != 3) {
    place.fail(value.line, "expected 3 numbers, found " + std::to_string(value.items.size()) +
                               ": write " + text_of_vec3(range));
  }
  return {read_number(value.items[0], place.at(0), range),
          read_number(value.items[1], place.at(1), range),
          read_number(value.items[2], place.at(2), range)};
}

const std::string& JsonFields::string(std::string_view key) const {
  return read_string(any(key, "a text in double quotes"), place_.at(key));
}

bool JsonFields::boolean(std::string_view key) const {
  const JsonValue& value = any(key, "true or false");
  expect(JsonKind::boolean, value, place_.at(key), [&] { return "write true or false"; });
  return value.is_true;
}

std::uint64_t JsonFields::integer(std::string_view key, IntegerRange range) const {
  return read_integer(any(key, text_of(range)), place_.at(key), range);
}

}  // namespace parray::input
