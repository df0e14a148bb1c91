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

/// Returns size and checksum of a file that consists of these pieces in order.
WholeFile whole_file_of(std::span<const std::string_view> pieces);

/// Reads a file and returns its size and checksum; nothing: it cannot be read.
std::optional<WholeFile> measure(const std::filesystem::path& file);

/// An open file or directory. The destructor closes it. Never blocks: a pipe or device in the place
/// of a file is an error (EINVAL).
class OpenPath {
 public:
  /// `flags` as for open(2).
  OpenPath(const std::filesystem::path& path, int flags);
  ~OpenPath();
  OpenPath& operator=(OpenPath&&) = delete;
  /// Returns the descriptor. -1: opening failed, and errno gives the reason.
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace parray::store
