#include "cli/input/scene_file/json_value.h"

#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::input {

std::string_view name_of(JsonKind kind) {
  switch (kind) {
    case JsonKind::null: return "null";
    case JsonKind::boolean: return "a boolean";
    case JsonKind::number: return "a number";
    case JsonKind::string: return "a string";
    case JsonKind::array: return "an array";
    case JsonKind::object: return "an object";
  }
  return "an unknown value";
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

}  // namespace parray::input
