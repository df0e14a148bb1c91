#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"

namespace parray::input {

/// A file of particles as lines of text and, from where a header ends, as binary data. Holds one
/// block of it.
class ParticleInput {
 public:
  /// Longer lines are refused: no format has them, and a binary file is told from text by them.
  static constexpr std::size_t max_line_bytes = std::size_t{1} << 16;
  static constexpr std::size_t max_bytes_at_once = max_line_bytes;

  /// `file` must outlive this.
  explicit ParticleInput(PackedFile& file);

  /// Goes to the next line; false at the end of the file.
  bool next_line();
  /// Goes to the next line that is not blank.
  bool next_filled_line();
  /// The line without its end, be that "\n", "\r\n" or, in a file whose first line
  /// ends so, "\r", and without a byte order mark; valid until
  /// the next call of next_line() or next_bytes().
  [[nodiscard]] std::string_view line() const { return line_; }

  /// The next `count` bytes, at most max_bytes_at_once; nullptr when the file ends before them.
  const char* next_bytes(std::size_t count) {
    place_.unit = FilePlace::Unit::byte;
    place_.number = taken_;
    if (filled_ - next_ < count && !fill(count)) return nullptr;
    const char* bytes = block_.data() + next_;
    next_ += count;
    taken_ += count;
    return bytes;
  }
  /// The next `count` bytes, as many as memory holds, which stay to be taken; nullptr when the file
  /// ends before them. Valid until any other call.
  const char* peek_bytes(std::size_t count);
  /// Takes the next `count` bytes, which have been looked at.
  void take_peeked(std::size_t count) {
    next_ += count;
    taken_ += count;
  }
  /// Passes over `count` bytes; false when the file ends before them.
  bool skip_bytes(std::uint64_t count);

  /// Bytes not taken yet; unknown for gzip data and pipes.
  [[nodiscard]] std::optional<std::uint64_t> bytes_left() const;
  /// Bytes taken so far.
  [[nodiscard]] std::uint64_t position() const { return taken_; }
  /// The line or bytes last taken.
  [[nodiscard]] const FilePlace& place() const { return place_; }
  [[noreturn]] void fail(std::string_view problem) const { place_.fail(problem); }

 private:
  bool refill();
  void find_line_end();
  bool fill(std::size_t count);

  PackedFile* file_;
  std::vector<char> block_;
  std::size_t next_ = 0;
  std::size_t filled_ = 0;
  std::uint64_t taken_ = 0;  // bytes of the file before block_[next_]
  std::string_view line_;
  std::uint64_t line_number_ = 0;
  char line_end_ = '\n';
  FilePlace place_;
};

}  // namespace parray::input
