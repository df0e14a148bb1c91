#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Returns all bytes of a file; nothing where it cannot be opened or read.
std::optional<std::string> read_file(const std::filesystem::path& path);

/// Makes the file hold `bytes` and nothing else; false where that fails, as on a full disk.
[[nodiscard]] bool write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace parray::base
