#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/json_value.h"

namespace parray {

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

/// How the value of a top-level key is handed over.
enum class JsonDelivery : std::uint8_t {
  whole,     ///< once, when it is complete
  by_item,   ///< an array, item by item
  by_member  ///< an object, member by member
};

/// Receives a JSON document piece by piece. Any exception that a member function throws ends the
/// parse and reaches the caller of parse_json().
class JsonSink {
 public:
  virtual ~JsonSink() = default;

  /// The document has the top-level key `key`, written on line `line`. Keys come in file order;
  /// refusing repeated ones is up to the sink, both here and in on_child().
  virtual JsonDelivery on_key(const std::string& key, std::uint64_t line) = 0;

  /// A whole top-level member.
  virtual void on_member(const JsonMember& member) = 0;

  /// The next item or member of the section that on_key() named last; `child.key` is empty for an
  /// item.
  virtual void on_child(const JsonMember& child) = 0;

  /// After on_child() with an item that is an object: may take more of the text, each time a comma
  /// and an item, all of them without fault; returns how many. What it leaves comes as usual.
  virtual std::size_t take_items(ByteSource& /*source*/) { return 0; }
};

/// A delivered value holds at most so many values, itself included: the scene's largest has 13.
inline constexpr std::size_t max_json_values_per_delivery = 256;

/// Reads one JSON document (RFC 8259, UTF-8, a byte order mark is skipped), whose top is an
/// object, and hands it to `sink`. Memory does not grow with the document.
///
/// Returns the line on which the document starts. Throws InputError "FILE:LINE: POINTER: PROBLEM"
/// for text that is not JSON, a number beyond double's range, a key twice in one object, nesting
/// deeper than limits::max_json_depth, and whatever ByteSource refuses.
std::uint64_t parse_json(std::istream& input, const std::string& file, JsonSink& sink);

}  // namespace parray
