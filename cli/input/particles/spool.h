#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>

#include "cli/input/particles/file_place.h"

namespace parray::input {

/// What errno says.
std::string last_system_error();

/// A file descriptor that closes itself.
class OpenFile {
 public:
  explicit OpenFile(int number = -1) : number_(number) {}
  OpenFile(OpenFile&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~OpenFile();

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// A temporary file without a name that holds what `read(to, bytes)` gives until it gives 0.
/// Throws InputError beyond limits::max_scene_file_bytes and when the temporary folder (TMPDIR,
/// else /tmp) does not take them.
OpenFile spooled(const std::function<std::size_t(char* to, std::size_t bytes)>& read,
                 const FilePlace& place);

}  // namespace parray::input
