#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"

namespace parray::input {

/// Reads a particle file as lines of text and, after a header, as binary data. Keeps one block of
/// the file in memory.
class ParticleInput {
 public:
  /// Longer lines are errors. They show that a file is binary.
  static constexpr std::size_t max_line_bytes = std::size_t{1} << 20;
  static constexpr std::size_t max_bytes_at_once = std::size_t{1} << 16;

  /// `file` must outlive this object.
  explicit ParticleInput(PackedFile& file);

  /// Goes to the next line. Returns false at the end of the file.
  bool next_line();
  /// Goes to the next line that is not blank. Returns false at the end of the file.
  bool next_filled_line();
  /// Goes to the next line. Throws InputError at the end of the file. The message says that `done`
  /// of `count` WHAT were read.
  void next_row(std::uint64_t done, std::uint64_t count, std::string_view what) {
    if (!next_line()) fail_within(done, count, what);
  }
  /// Skips `count` lines of a frame. Throws InputError if the file ends before.
  void skip_rows(std::uint64_t count);
  /// Returns the line without its end ("\n" or "\r\n"; "\r" if the first line ends so) and without
  /// a byte order mark. Valid until the next call that reads or peeks.
  [[nodiscard]] std::string_view line() const { return line_; }

  /// Returns the next `count` bytes, at most max_bytes_at_once; nullptr if the file ends before.
  /// Valid until the next call that reads or peeks.
  const char* next_bytes(std::size_t count) {
    place_.unit = FilePlace::Unit::byte;
    place_.number = taken_;
    if (filled_ - next_ < count && !fill(count)) return nullptr;
    const char* bytes = block_.data() + next_;
    next_ += count;
    taken_ += count;
    return bytes;
  }
  /// Returns the next `count` bytes without taking them; nullptr if the file ends before. `count`
  /// is limited by memory only. Valid until any other call.
  const char* peek_bytes(std::size_t count);
  /// Takes the next `count` bytes, which peek_bytes() has returned.
  void take_peeked(std::size_t count) {
    next_ += count;
    taken_ += count;
  }
  /// Skips `count` bytes. Returns false if the file ends before.
  bool skip_bytes(std::uint64_t count);

  /// Returns the number of unread bytes. Returns nothing for packed data.
  [[nodiscard]] std::optional<std::uint64_t> bytes_left() const;
  /// Returns the number of bytes taken so far.
  [[nodiscard]] std::uint64_t position() const { return taken_; }
  /// Returns the place of the line or bytes that were read last.
  [[nodiscard]] const FilePlace& place() const { return place_; }
  /// Throws InputError with place() and `problem`.
  [[noreturn]] void fail(std::string_view problem) const { place_.fail(problem); }
  [[noreturn]] void fail_incomplete(std::string_view problem) const {
    place_.fail_incomplete(problem);
  }

 private:
  [[noreturn]] void fail_within(std::uint64_t done, std::uint64_t count,
                                std::string_view what) const;
  bool refill();
  void find_line_end();
  bool fill(std::size_t count);

  PackedFile* file_;
  std::vector<char> block_;
  std::size_t next_ = 0;
  std::size_t filled_ = 0;
  std::uint64_t taken_ = 0;  // number of bytes of the file before block_[next_]
  std::string_view line_;
  std::uint64_t line_number_ = 0;
  char line_end_ = '\n';
  FilePlace place_;
};

}  // namespace parray::input
