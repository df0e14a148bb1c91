#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "common/rooms.h"

namespace parray::store {

/// Size and XXH3-64 of a file that is written once and never changed.
struct WholeFile {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
  friend bool operator==(const WholeFile&, const WholeFile&) = default;
};

/// Size and checksum of a file that consists of the pieces, one after the other.
WholeFile whole_file_of(std::span<const std::string_view> pieces);

/// Size and checksum of a file as it is; nothing: it cannot be read.
std::optional<WholeFile> measure(const std::filesystem::path& file);

/// An open file or directory, closed with its scope. Never waits: a pipe or a device in the place
/// of a file is an error (EINVAL).
class OpenPath {
 public:
  /// Flags and creation as of open(2).
  OpenPath(const std::filesystem::path& path, int flags);
  ~OpenPath();
  OpenPath(const OpenPath&) = delete;
  OpenPath& operator=(const OpenPath&) = delete;
  /// -1: it could not be opened, and errno says why.
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace parray::store
