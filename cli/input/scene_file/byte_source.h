#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// The bytes of a stream, read once in blocks, with the number of the line that is being read.
///
/// Throws InputError for a zero byte (JSON text has none, and the parser takes one for the end of
/// the input), for more than limits::max_scene_file_bytes bytes, for more than max_token_bytes
/// bytes since the last mark_token() and for a failing read.
class ByteSource {
 public:
  /// Bounds what the JSON lexer keeps: its buffer grows with a string and with a run of blanks.
  static constexpr std::size_t max_token_bytes = std::size_t{1} << 20;

  /// `stream` must outlive this; `file` names it in messages.
  ByteSource(std::istream& stream, std::string file);

  bool at_end() { return next_ == filled_ && !refill(); }

  /// The next byte; only where !at_end().
  char peek() const { return block_[next_]; }

  void advance() {
    const char c = block_[next_++];
    // The lexer reads one byte beyond a number. A line therefore ends not with its newline, but
    // with the byte after that: the number still belongs to the line on which it stands.
    line_ += after_newline_ ? 1 : 0;
    after_newline_ = c == '\n';
    if (c == '\0') fail_zero_byte();
  }

  /// The next bytes, at least `least` of them unless the stream ends before.
  std::string_view ahead(std::size_t least);

  /// Goes over bytes that ahead() has shown: JSON text that does not end with a newline.
  void skip(std::size_t bytes, std::size_t newlines) {
    line_ += newlines + (after_newline_ ? 1 : 0);
    after_newline_ = false;
    next_ += bytes;
    mark_token();
  }

  /// Line of the byte last read, counted from 1.
  std::uint64_t line() const { return line_; }

  /// Whether somebody has asked for a byte beyond the last.
  bool end_was_reached() const { return end_was_reached_; }

  void mark_token() { token_start_ = blocks_total_ - (filled_ - next_); }

 private:
  bool refill();
  void load();
  [[noreturn]] void fail_zero_byte() const;

  std::istream* stream_;
  std::string file_;
  std::vector<char> block_;
  std::size_t next_ = 0;
  std::size_t filled_ = 0;
  std::uint64_t blocks_total_ = 0;  // bytes read so far, those in the block included
  std::uint64_t token_start_ = 0;
  std::uint64_t line_ = 1;
  bool after_newline_ = false;
  bool end_was_reached_ = false;
};

/// Input iterator over a ByteSource, as nlohmann::json::sax_parse takes it. Copies share the
/// source; a default-constructed one is the end.
class ByteIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = char;

  ByteIterator() = default;
  explicit ByteIterator(ByteSource& source) : source_(&source) {}

  char operator*() const { return source_->peek(); }
  ByteIterator& operator++() {
    source_->advance();
    return *this;
  }
  void operator++(int) { source_->advance(); }
  friend bool operator==(const ByteIterator& a, const ByteIterator& b) {
    return a.at_end() == b.at_end();
  }

 private:
  bool at_end() const { return source_ == nullptr || source_->at_end(); }

  ByteSource* source_ = nullptr;
};

}  // namespace parray::input
