#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/json_value.h"

namespace parray::input {

/// Reads the bytes of a stream once, in blocks, and counts lines.
///
/// Throws InputError for a zero byte, because JSON text has none and the parser would treat it as
/// the end of the input. Throws it also for more than limits::max_scene_file_bytes bytes, for a
/// token or a run of blanks of more than max_token_bytes bytes, and for a failing read.
class ByteSource {
 public:
  /// Limits the buffer of the JSON lexer, which grows with strings and with runs of blanks.
  static constexpr std::size_t max_token_bytes = std::size_t{1} << 20;

  /// `stream` must outlive this object. `file` names it in messages.
  ByteSource(std::istream& stream, std::string file);

  bool at_end() { return next_ == filled_ && !refill(); }

  /// Returns the next byte. Requires !at_end().
  char peek() const { return block_[next_]; }

  void advance() {
    const char c = block_[next_++];
    // The lexer reads one byte beyond a number. Therefore the line number changes not at the
    // newline but at the byte after it. So the number is reported on its own line.
    line_ += after_newline_ ? 1 : 0;
    after_newline_ = c == '\n';
    if (c == '\0') fail_zero_byte();
  }

  /// Returns the next bytes without reading them. They are at least `least` (up to 64 KiB) unless
  /// the stream ends before. Valid until the next call.
  std::string_view ahead(std::size_t least);

  /// Skips bytes that ahead() returned. They are JSON text that does not end with a newline.
  void skip(std::size_t bytes, std::size_t newlines) {
    line_ += newlines + (after_newline_ ? 1 : 0);
    after_newline_ = false;
    next_ += bytes;
    mark_token();
  }

  /// Returns the line of the last byte read, from 1.
  std::uint64_t line() const { return line_; }

  /// Returns whether the parser asked for a byte beyond the end.
  bool end_was_reached() const { return end_was_reached_; }

  /// Marks that a token ended with the last byte read.
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
  std::uint64_t blocks_total_ = 0;  // bytes read so far, including those in the block
  std::uint64_t token_start_ = 0;
  std::uint64_t line_ = 1;
  bool after_newline_ = false;
  bool end_was_reached_ = false;
};

/// How a sink receives the value of a top-level key.
enum class JsonDelivery : std::uint8_t {
  whole,     ///< in one piece, when the value is complete
  by_item,   ///< an array, item by item
  by_member  ///< an object, member by member
};

/// Receives a JSON document in pieces. An exception of a member function ends the parse and reaches
/// the caller of parse_json().
class JsonSink {
 public:
  virtual ~JsonSink() = default;

  /// Announces the top-level key `key` on line `line`. Keys come in the order of the file. The sink
  /// must reject repeated keys itself, here and in on_child().
  virtual JsonDelivery on_key(const std::string& key, std::uint64_t line) = 0;

  /// Delivers a whole top-level member.
  virtual void on_member(const JsonMember& member) = 0;

  /// Delivers the next item or member of the section that on_key() announced last. `child.key` is
  /// empty for an item.
  virtual void on_child(const JsonMember& child) = 0;

  /// A faster way to read long arrays. The parser calls it after on_child() has received an item
  /// that is an object. The sink may then read the next items from `source` itself, each with the
  /// comma before it. It must stop before the first item that it cannot read. Returns the number of
  /// items that it has read. The parser delivers all other items.
  virtual std::size_t take_items(ByteSource& /*source*/) { return 0; }
};

/// Largest number of values in one delivery, that is one call of on_member() or on_child(). It
/// includes the delivered value and all values inside it. An item of `particles` has the most:
/// max_representations in `show`, each with up to 13 values.
inline constexpr std::size_t max_json_values_per_delivery = 4096;

/// Parses a JSON document (RFC 8259, UTF-8, an optional byte order mark) whose top level is an
/// object. Delivers it to `sink`. Memory does not grow with the document.
///
/// Returns the line on which the document starts. Throws InputError "FILE:LINE: POINTER: PROBLEM"
/// for text that is not JSON, a number beyond double's range, a repeated key in an object inside a
/// delivery, nesting deeper than limits::max_json_depth, and more than max_json_values_per_delivery
/// values. Throws it also for a value of another kind than its JsonDelivery. Throws the errors of
/// ByteSource.
std::uint64_t parse_json(std::istream& input, const std::string& file, JsonSink& sink);

}  // namespace parray::input
