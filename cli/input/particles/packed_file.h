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

namespace parray {

/// The first bytes of a file, unpacked: what tells its format.
class FileStart {
 public:
  static constexpr std::size_t max_bytes = std::size_t{1} << 16;

  /// `whole`: the file has no more. `bytes` must outlive this.
  FileStart(std::string_view bytes, bool whole);

  [[nodiscard]] std::string_view bytes() const { return bytes_; }
  [[nodiscard]] bool whole() const { return whole_; }
  /// Whether `signature` stands there, `at` bytes from the front.
  [[nodiscard]] bool has(std::string_view signature, std::size_t at = 0) const {
    return at <= bytes_.size() && bytes_.substr(at).starts_with(signature);
  }
  /// Four bytes as a whole number, least significant first; 0 beyond the end.
  [[nodiscard]] std::uint32_t little_endian(std::size_t at) const;
  /// The same, most significant first.
  [[nodiscard]] std::uint32_t big_endian(std::size_t at) const;

  /// Whether it has no control characters but blanks and the ends of lines and pages.
  [[nodiscard]] bool is_text() const { return is_text_; }
  /// Of text: the lines that are there from end to end, at most max_lines, without their ends, be
  /// they "\n", "\r\n" or "\r", and without a byte order mark. Of anything else: none.
  [[nodiscard]] const std::vector<std::string_view>& lines() const { return lines_; }
  /// Whether one of the lines is `text`, blanks at its ends aside.
  [[nodiscard]] bool has_line(std::string_view text) const;
  /// Line i, from 0; empty where there is none.
  [[nodiscard]] std::string_view line(std::size_t i) const {
    return i < lines_.size() ? lines_[i] : std::string_view();
  }
  static constexpr std::size_t max_lines = 200;

 private:
  void split_lines(std::string_view text);

  std::string_view bytes_;
  bool whole_;
  bool is_text_;
  std::vector<std::string_view> lines_;
};

/// A file descriptor that closes itself.
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

}  // namespace parray
