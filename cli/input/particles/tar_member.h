#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
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

/// The bytes of the only file in an archive.
class TarMember : public Unpacker {
 public:
  /// `archive` is at its front. has_one_file() is true for it.
  explicit TarMember(std::unique_ptr<Unpacker> archive);

  std::ptrdiff_t read(char* to, std::size_t bytes) override;
  [[nodiscard]] std::string problem() const override;

 private:
  std::unique_ptr<Unpacker> archive_;
  std::uint64_t left_ = 0;  // bytes of the file that are not read
  bool cut_ = false;        // the archive ends before the file
};

}  // namespace parray::input
