#include "cli/input/particles/file_place.h"

#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::input {

void FilePlace::fail(std::string_view problem) const {
  constexpr std::size_t longest_path = 4096;
  std::string message = printable(file, longest_path);
  if (unit == Unit::line) message += ":" + std::to_string(number);
  if (unit == Unit::byte) message += ": byte " + std::to_string(number);
  throw InputError(message.append(": ").append(problem));
}

}  // namespace parray::input
