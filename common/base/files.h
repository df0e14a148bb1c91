#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/rooms.h"

namespace parray::base {

/// Returns all bytes of a file; nothing where it cannot be opened or read.
std::optional<std::string> read_file(const std::filesystem::path& path);

/// Makes the file hold `bytes` and nothing else; false where that fails, as on a full disk.
[[nodiscard]] bool write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes a directory for this user only. Its name is `start` and six more characters. Returns an
/// empty path, and sets errno, if that fails.
std::filesystem::path make_directory(const std::filesystem::path& start);

/// Deletes a file, or a directory with its content, at the end of its life.
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
