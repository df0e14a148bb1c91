#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Returns all bytes of a file; nothing if it cannot be opened or read, or is a directory.
std::optional<std::string> read_file(const std::filesystem::path& path);

/// Replaces the content of the file by `bytes`, in place. Returns whether that succeeded. If not,
/// for example on a full disk, the file may contain a part of `bytes`.
[[nodiscard]] bool write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace parray::base
