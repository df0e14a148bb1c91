#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/rooms.h"

namespace parray::base {

/// Returns all bytes of a file; nothing if it cannot be opened or read, or is a directory.
std::optional<std::string> read_file(const std::filesystem::path& path);

/// Replaces the content of the file by `bytes`, in place. Returns whether that succeeded. If not,
/// for example on a full disk, the file may contain a part of `bytes`.
[[nodiscard]] bool write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes a directory for this user only. Its name is `start` and six more characters. Returns an
/// empty path, and sets errno, if that fails.
std::filesystem::path make_directory(const std::filesystem::path& start);

/// Owns a file, or a directory with its content: the destructor deletes it.
class OwnedPath {
 public:
  explicit OwnedPath(std::filesystem::path path) : path_(std::move(path)) {}
  ~OwnedPath();
  OwnedPath& operator=(OwnedPath&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace parray::base
