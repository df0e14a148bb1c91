#include "cli/input/particles/file_place.h"

#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {

void FilePlace::fail(std::string_view problem) const {
  constexpr std::size_t longest_path = 4096;
  std::string message = printable(file, longest_path);
  if (unit == Unit::line) message += ":" + std::to_string(number);
  if (unit == Unit::byte) message += ": byte " + std::to_string(number);
  throw InputError(message.append(": ").append(problem));
}

void FilePlace::fail_damaged(std::string_view problem) const {
  fail(std::string(problem) + ": the file is probably damaged, copy it again");
}

void FilePlace::fail_incomplete(std::string_view problem) const {
  fail(std::string(problem) + ": check that the file is complete");
}

double number_field(std::string_view text, std::string_view what, const FilePlace& place) {
  const std::optional<double> value = number_in(text);
  if (!value) {
    place.fail(std::string(what) + " '" + printable(text) +
               "' is not a finite number: write a number such as 0.5 or 1e3");
  }
  return *value;
}

Vec3d position_field(const std::vector<std::string_view>& words, std::size_t at,
                     const FilePlace& place) {
  const double x = number_field(words[at], "x", place);
  const double y = number_field(words[at + 1], "y", place);
  return {x, y, number_field(words[at + 2], "z", place)};
}

std::uint64_t count_field(std::string_view text, const FilePlace& place) {
  const std::optional<std::uint64_t> count = natural_in(text);
  if (!count) {
    place.fail("'" + printable(text) + "' is not a number of particles: write a whole number");
  }
  if (*count > limits::max_shapes) {
    place.fail(std::to_string(*count) + " particles are too many: use at most " +
               std::to_string(limits::max_shapes));
  }
  return *count;
}

}  // namespace parray::input
