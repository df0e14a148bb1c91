#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/input/particles/file_place.h"

namespace parray {

/// The bytes of a file, read once from front to back; gzip data (recognised by its first bytes,
/// not by the file's name) is expanded on the way.
class PackedFile {
 public:
  /// Throws InputError for what cannot be opened or is no file.
  explicit PackedFile(const std::filesystem::path& path);

  /// Fills `to` with the next `bytes` bytes, fewer only at the end of the file; returns how many.
  /// Throws InputError for damaged or incomplete gzip data, a failing disk, and beyond
  /// limits::max_scene_file_bytes expanded bytes.
  std::size_t read(char* to, std::size_t bytes);

  /// Bytes that read() gives in all; unknown for gzip data and pipes.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return size_; }
  [[nodiscard]] const std::string& name() const { return place_.file; }

 private:
  void check_error() const;

  struct Close {
    void operator()(gzFile file) const { gzclose_r(file); }
  };
  FilePlace place_;
  std::unique_ptr<gzFile_s, Close> file_;
  std::optional<std::uint64_t> size_;
  std::uint64_t total_ = 0;
};

}  // namespace parray
