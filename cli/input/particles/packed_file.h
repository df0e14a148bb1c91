#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/unpacker.h"

namespace parray::input {

/// The first unpacked bytes of a file. They identify its format.
class FileStart {
 public:
  static constexpr std::size_t usual_bytes = std::size_t{1} << 16;

  /// `whole`: the file has no more bytes. `bytes` must outlive this object.
  FileStart(std::string_view bytes, bool whole);

  [[nodiscard]] std::string_view bytes() const { return bytes_; }
  [[nodiscard]] bool whole() const { return whole_; }
  /// Returns whether `signature` stands at byte `at`.
  [[nodiscard]] bool has(std::string_view signature, std::size_t at = 0) const {
    return at <= bytes_.size() && bytes_.substr(at).starts_with(signature);
  }
  /// Returns the four bytes at `at` as a little-endian number; 0 if any of them is beyond the end.
  [[nodiscard]] std::uint32_t little_endian(std::size_t at) const;
  /// Returns the four bytes at `at` as a big-endian number; 0 if any of them is beyond the end.
  [[nodiscard]] std::uint32_t big_endian(std::size_t at) const;

  /// Returns whether the bytes contain no control characters except blanks, line ends and page
  /// breaks.
  [[nodiscard]] bool is_text() const { return is_text_; }
  /// Returns the complete lines of a text without line ends ("\n", "\r\n" or "\r") and without a
  /// byte order mark. A last line without a line end is complete if whole(). Returns none for
  /// binary data.
  [[nodiscard]] const std::vector<std::string_view>& lines() const { return lines_; }
  /// Returns whether a line equals `text` after removal of blanks at its ends.
  [[nodiscard]] bool has_line(std::string_view text) const;
  /// Returns line i, from 0. Returns an empty text beyond the last line.
  [[nodiscard]] std::string_view line(std::size_t i) const {
    return i < lines_.size() ? lines_[i] : std::string_view();
  }

 private:
  void split_lines(std::string_view text);

  std::string_view bytes_;
  bool whole_;
  bool is_text_;
  std::vector<std::string_view> lines_;
};

/// A file descriptor that closes itself. -1: none.
class OpenFile {
 public:
  explicit OpenFile(int number = -1) : number_(number) {}
  OpenFile(OpenFile&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~OpenFile();

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// The bytes of a file. They can be read from front to back several times. Unpacks data of gzip,
/// bzip2, xz and zstd, which it recognises by their first bytes, not by the name. A tar archive
/// that contains one file, packed or not, counts as that file. Other archives are not opened: no
/// reader knows their format.
class PackedFile {
 public:
  /// Opens a file. Copies files that can be read only once, such as pipes, to a temporary file
  /// without a name. Throws InputError if the file cannot be opened or copied, is a directory, or
  /// is empty.
  explicit PackedFile(const std::filesystem::path& path);
  /// Opens the file that a command line names. "-" means the standard input.
  static PackedFile of_argument(const std::string& argument);
  PackedFile& operator=(PackedFile&&) = delete;

  /// Fills `to` with the next `bytes` bytes, fewer only at the end of the file. Returns their
  /// number. Throws InputError for damaged or incomplete packed data and for a failing disk. Throws
  /// it also beyond limits::max_scene_file_bytes unpacked bytes since the front of the file.
  std::size_t read(char* to, std::size_t bytes);
  /// Skips `bytes` bytes. Returns false if the file ends before. Takes no time unless the data are
  /// packed or in an archive; then it throws as read() does.
  bool skip(std::uint64_t bytes);
  /// Returns to the front of the file.
  void rewind();
  /// Returns how often the file has returned to its front. A reader of frames notices by this
  /// number that others have read the file meanwhile.
  [[nodiscard]] std::uint64_t rewinds() const { return rewinds_; }

  /// Returns the first `bytes` bytes or more; fewer only if the file is shorter. The reference is
  /// valid until a call with more bytes. Such a call, and the first one, also return to the front
  /// of the file.
  const FileStart& start(std::size_t bytes = FileStart::usual_bytes);
  /// Returns the name of the compression or of the archive: "gzip", "tar", "tar.gz". Empty:
  /// neither.
  [[nodiscard]] std::string_view packing() const { return packing_; }

  /// Returns the total number of bytes that read() gives. Returns nothing for packed data and for
  /// archives.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return size_; }
  /// Returns the path, or "standard input", for messages.
  [[nodiscard]] const std::string& name() const { return place_.file; }
  /// Returns the path; empty for the standard input.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  struct StandardInput {};
  explicit PackedFile(StandardInput /*unused*/);
  void take(OpenFile file);
  std::size_t read_packed(char* to, std::size_t bytes);

  FilePlace place_;
  std::filesystem::path path_;
  OpenFile file_;
  std::string_view packing_;
  std::unique_ptr<Unpacker> unpacker_;  // only for packed data
  std::optional<std::uint64_t> size_;
  std::uint64_t position_ = 0;  // in the unpacked bytes
  std::uint64_t rewinds_ = 0;
  std::uint64_t total_ = 0;  // bytes read or unpacked since the front
  std::string start_bytes_;
  std::optional<FileStart> start_;
};

/// Means the standard input on a command line.
inline constexpr std::string_view standard_input_argument = "-";

/// Returns `path` without the extension of a compressed file: "a.pdb" for "a.pdb.zst".
std::filesystem::path unpacked_name(const std::filesystem::path& path);

}  // namespace parray::input
