#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/file_start.h"
#include "cli/input/particles/spool.h"
#include "cli/input/particles/unpacker.h"

namespace parray::input {

/// The bytes of a file that somebody wants to be read, from front to back and as often as needed.
/// Data packed by gzip, bzip2, xz or zstd (told by their first bytes, not by the file's name) are
/// expanded on the way.
class PackedFile {
 public:
  /// What is no regular file and can be read but once is kept in a temporary file without a name.
  /// Throws InputError for what cannot be opened, is no file, or is empty.
  explicit PackedFile(const std::filesystem::path& path);
  /// As people name it: "-" is the standard input.
  static PackedFile of_argument(const std::string& argument);
  PackedFile(const PackedFile&) = delete;
  PackedFile& operator=(const PackedFile&) = delete;

  /// Fills `to` with the next `bytes` bytes, fewer only at the end of the file; returns how many.
  /// Throws InputError for damaged or incomplete packed data, a failing disk, and beyond
  /// limits::max_scene_file_bytes expanded bytes.
  std::size_t read(char* to, std::size_t bytes);
  /// Passes over `bytes` bytes; false when the file ends before them. At no cost unless the data
  /// are packed.
  bool skip(std::uint64_t bytes);
  /// Back to the front.
  void rewind();

  /// The first bytes. Goes back to the front when it is called first.
  const FileStart& start();
  /// What data are packed by: "gzip"; empty: they are not packed.
  [[nodiscard]] std::string_view packing() const { return packing_; }

  /// Bytes that read() gives in all; unknown for packed data.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return size_; }
  /// For messages: the path, or "standard input".
  [[nodiscard]] const std::string& name() const { return place_.file; }
  /// Empty: the standard input.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  struct StandardInput {};
  explicit PackedFile(StandardInput /*unused*/);
  void take(OpenFile file);
  std::size_t read_plain(char* to, std::size_t bytes);
  std::size_t read_packed(char* to, std::size_t bytes);

  FilePlace place_;
  std::filesystem::path path_;
  OpenFile file_;
  std::string_view packing_;
  std::unique_ptr<Unpacker> unpacker_;  // of packed data
  std::optional<std::uint64_t> size_;
  std::uint64_t position_ = 0;  // in the unpacked bytes
  std::uint64_t total_ = 0;     // bytes read since the front, without those passed over
  std::string start_bytes_;
  std::optional<FileStart> start_;
};

/// Names the standard input on a command line.
inline constexpr std::string_view standard_input_argument = "-";

/// `path` without the extension of a packed file: "a.pdb" for "a.pdb.zst".
std::filesystem::path unpacked_name(const std::filesystem::path& path);

}  // namespace parray::input
