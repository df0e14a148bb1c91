#pragma once

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "cli/input/particles/particles.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/packed.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {

/// Writes and reads particle files in a directory of one test.
class ParticleFiles {
 public:
  [[nodiscard]] std::filesystem::path write(const std::string& name,
                                            const std::string& bytes) const {
    std::filesystem::path path = directory_.path() / name;
    std::filesystem::remove(
        path);  // some file systems flush a file that is truncated and rewritten
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  [[nodiscard]] Particles read(const std::string& name, const std::string& bytes) const {
    return read_particles(write(name, bytes));
  }

  /// Returns the error message of reading, without the directory, or "no error".
  [[nodiscard]] std::string message(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path path = write(name, bytes);
    std::string message = message_of<InputError>([&] { read_particles(path); });
    const std::string prefix = (directory_.path() / "").string();
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
    return message;
  }

  [[nodiscard]] const std::filesystem::path& path() const { return directory_.path(); }

 private:
  TemporaryDirectory directory_;
};

/// Returns the bytes of a value in the given byte order.
template <typename T>
std::string bytes_of(T value, std::endian order = std::endian::little) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (order != std::endian::native) bytes.assign(bytes.rbegin(), bytes.rend());
  return bytes;
}

}  // namespace parray::test
