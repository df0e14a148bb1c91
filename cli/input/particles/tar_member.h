#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "cli/input/particles/unpacker.h"

/// Tar archives that contain one file: POSIX.1-1988 (ustar), POSIX.1-2001 (pax) and GNU.
namespace parray::input {

/// Size of a header in bytes. In an archive, data are padded to a multiple of this size.
inline constexpr std::size_t tar_block_bytes = 512;

/// Returns whether the first tar_block_bytes bytes of a file are those of a tar archive.
bool begins_tar(std::string_view start);

/// Returns whether the archive contains exactly one file, and otherwise only folders and
/// attributes. Returns false for damaged archives. Reads `archive`, which must be at its front. To
/// read the file afterwards, open the archive again.
bool has_one_file(Unpacker& archive);

/// Returns the bytes of the only file in an archive, which is at its front. has_one_file() is true
/// for it.
std::unique_ptr<Unpacker> tar_member(std::unique_ptr<Unpacker> archive);

}  // namespace parray::input
