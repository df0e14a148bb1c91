#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>

#include "cli/input/scene_file/json_value.h"

namespace parray::input {

class ByteSource;

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

}  // namespace parray::input
