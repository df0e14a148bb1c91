#include "cli/input/scene_file/json_stream.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Returns the reason after "syntax error while parsing X - ", without the token and the rest.
std::string_view reason_in(std::string_view what) {
  constexpr std::string_view dash = " - ";
  const std::size_t start = what.find(dash, std::min(what.size(), what.find("syntax error")));
  if (start == std::string_view::npos) return "invalid text";
  what.remove_prefix(start + dash.size());
  return what.substr(0, what.find("; last read: '"));
}

/// Returns whether a token is NaN, Infinity, inf, nan or -Infinity, cut where the lexer stopped.
bool looks_like_infinity_or_nan(std::string_view token) {
  return token.ends_with('N') || token.ends_with('I') || token.ends_with('i') ||
         token.ends_with("na");
}

std::string_view remedy_for(std::string_view reason, std::string_view token) {
  const bool bad_word = reason.starts_with("invalid literal") || reason.starts_with("invalid num");
  if (bad_word && looks_like_infinity_or_nan(token)) {
    return "JSON has no NaN or Infinity; write finite numbers, and words in double quotes";
  }
  if (bad_word && (token.ends_with('/') || token.ends_with('#'))) {
    return "JSON has no comments; remove them";
  }
  if (bad_word && token.ends_with('\'')) return "write strings in double quotes";
  if (bad_word && (token.ends_with('\xff') || token.ends_with('\xfe'))) {
    return "the text looks like UTF-16; save the file as UTF-8";
  }
  if (bad_word) return "write a number such as 0.5 or 1e3, or a string in double quotes";
  if (reason.starts_with("unexpected ']'") || reason.starts_with("unexpected '}'")) {
    return reason.ends_with("expected ']'") ? "close the list with ]"
           : reason.ends_with("expected '}'")
               ? "close the object with }"
               : "remove the comma before the bracket, or write what is missing";
  }
  if (reason.find("UTF-8") != std::string_view::npos) return "save the file as UTF-8";
  return "look for a missing quote, comma or bracket";
}

/// Returns the end of the text that the lexer read: at most a few words of the wrong line.
std::string_view last_words(std::string_view token) {
  constexpr std::string_view line_end = "<U+000A>";  // the lexer's form of a newline
  constexpr std::size_t most = 24;
  const std::size_t line = token.rfind(line_end);
  if (line != std::string_view::npos && line + line_end.size() < token.size()) {
    token.remove_prefix(line + line_end.size());
  }
  if (token.size() > most) token.remove_prefix(token.size() - most);
  token.remove_prefix(std::min(token.size(), token.find_first_not_of(' ')));
  return token;
}

/// Turns nlohmann's description of a syntax error into ParRay's form: "not JSON (REASON): REMEDY".
///
/// `what` is nlohmann's message, "[...] parse error at ...: syntax error while parsing X - REASON[;
/// last read: 'TOKEN'][; expected Y]". `last_token` is the text that the lexer had read. It may
/// contain any bytes.
std::string describe_syntax_error(std::string_view what, std::string_view last_token) {
  const std::string_view reason = reason_in(what);
  std::string out = "the text is not JSON (" + printable(reason, 200);
  if (what.find("; last read: '") != std::string_view::npos) {
    out += " at '" + printable(last_words(last_token)) + "'";
  }
  out.append("): ").append(remedy_for(reason, last_token));
  return out;
}

using Json = nlohmann::json;

/// An input iterator over a ByteSource for nlohmann::json::sax_parse. Copies share the source. A
/// default-constructed iterator is the end.
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

/// Turns nlohmann's SAX events into deliveries. nlohmann's text parser is iterative, so only this
/// class must limit the depth.
class SaxHandler {
 public:
  SaxHandler(ByteSource& source, const std::string& file, JsonSink& sink)
      : source_(source), file_(file), sink_(sink) {}

  std::uint64_t start_line() const { return start_line_; }

  bool null() { return put(make(JsonKind::null)); }
  bool boolean(bool value) {
    JsonValue out = make(JsonKind::boolean);
    out.is_true = value;
    return put(std::move(out));
  }
  bool binary(Json::binary_t&) { return put(make(JsonKind::null)); }  // does not occur in JSON text

  bool number_integer(Json::number_integer_t number) {
    JsonValue value = make(JsonKind::number);
    value.number = static_cast<double>(number);
    value.is_natural = number == 0;  // "-0"
    return put(std::move(value));
  }

  bool number_unsigned(Json::number_unsigned_t number) {
    JsonValue value = make(JsonKind::number);
    value.number = static_cast<double>(number);
    value.natural = number;
    value.is_natural = true;
    return put(std::move(value));
  }

  bool number_float(Json::number_float_t number, const std::string&) {
    JsonValue value = make(JsonKind::number);
    value.number = number;
    return put(std::move(value));
  }

  bool string(std::string& text) {
    JsonValue value = make(JsonKind::string);
    value.text = std::move(text);
    return put(std::move(value));
  }

  bool start_object(std::size_t) { return open(JsonKind::object); }
  bool start_array(std::size_t) { return open(JsonKind::array); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(std::string& text) {
    source_.mark_token();
    Frame& frame = frames_.back();
    frame.key = std::move(text);
    frame.key_line = source_.line();
    const auto is_same = [&](const JsonMember& member) { return member.key == frame.key; };
    if (is_section()) {
      values_ = 0;
      delivery_ = sink_.on_key(frame.key, frame.key_line);
    } else if (std::ranges::any_of(frame.value.members, is_same)) {
      fail("duplicate key '" + printable(frame.key) + "': remove one of them");
    }
    return true;
  }

  bool parse_error(std::size_t, const std::string& last_token, const Json::exception& error) {
    if (started_ && frames_.empty()) fail("text follows the end of the JSON object: remove it");
    if (source_.end_was_reached()) {
      fail(started_ ? "the file ends within the JSON object: check that the file is complete"
                    : "the file ends before a JSON object begins: write a JSON object");
    }
    constexpr int number_overflow = 406;
    if (error.id == number_overflow) {
      fail("number " + printable(last_token) + " is too large: use a number below 1e308");
    }
    fail(describe_syntax_error(error.what(), last_token));
  }

 private:
  /// An array or object whose end was not read yet.
  struct Frame {
    JsonValue value;
    std::string key;             // key of the current member
    std::uint64_t key_line = 0;  // line of that key
    std::size_t count = 0;       // number of complete children
  };

  JsonValue make(JsonKind kind) {
    source_.mark_token();
    JsonValue value;
    value.kind = kind;
    value.line = source_.line();
    return value;
  }

  bool open(JsonKind kind) {
    JsonValue value = make(kind);
    if (frames_.empty()) {
      if (kind != JsonKind::object) {
        fail("expected an object, found an array: check that this is the right file");
      }
      start_line_ = value.line;
      started_ = true;
    } else if (is_section()) {
      check_section_kind(kind);
    }
    if (frames_.size() >= limits::max_json_depth) {
      fail("values are nested deeper than " + std::to_string(limits::max_json_depth) +
           " levels: remove levels");
    }
    const bool is_streamed = is_section() && delivery_ != JsonDelivery::whole;
    if (!is_streamed) count_value();
    frames_.push_back({std::move(value), {}, 0, 0});
    return true;
  }

  bool close() {
    source_.mark_token();
    JsonValue value = std::move(frames_.back().value);
    frames_.pop_back();
    if (frames_.empty()) return true;
    if (is_section() && delivery_ != JsonDelivery::whole) {
      ++frames_.back().count;  // its children were delivered already
      return true;
    }
    --values_;  // open() counted it
    return put(std::move(value));
  }

  bool put(JsonValue value) {
    if (frames_.empty()) {
      fail("expected an object, found " + std::string(name_of(value.kind)) +
           ": check that this is the right file");
    }
    count_value();
    Frame& parent = frames_.back();
    if (is_section()) {
      check_section_kind(value.kind);
      sink_.on_member({parent.key, parent.key_line, std::move(value)});
      values_ = 0;
    } else if (is_child()) {
      const bool is_object =
          value.kind == JsonKind::object;  // the end of an object is the last byte read so far
      sink_.on_child({parent.key, parent.key_line, std::move(value)});
      if (is_object && delivery_ == JsonDelivery::by_item) {
        parent.count += sink_.take_items(source_);
      }
      values_ = 0;
    } else if (parent.value.kind == JsonKind::array) {
      if (parent.value.items.empty()) parent.value.items.reserve(3);  // most are vectors
      parent.value.items.push_back(std::move(value));
    } else {
      if (parent.value.members.empty()) parent.value.members.reserve(4);
      parent.value.members.push_back({parent.key, parent.key_line, std::move(value)});
    }
    ++parent.count;
    return true;
  }

  /// Fails if the section is delivered in pieces but has another kind than its delivery needs.
  void check_section_kind(JsonKind kind) const {
    if (delivery_ == JsonDelivery::whole) return;
    const JsonKind due = delivery_ == JsonDelivery::by_item ? JsonKind::array : JsonKind::object;
    if (kind == due) return;
    fail("expected " + std::string(name_of(due)) + ", found " + std::string(name_of(kind)) +
         ": write " + (due == JsonKind::array ? "[ ... ]" : "{ ... }"));
  }

  void count_value() {
    if (++values_ <= max_json_values_per_delivery) return;
    fail("one value has more than " + std::to_string(max_json_values_per_delivery) +
         " parts: remove some");
  }

  bool is_section() const { return frames_.size() == 1; }
  bool is_child() const { return frames_.size() == 2 && delivery_ != JsonDelivery::whole; }

  std::string pointer() const {
    std::string out;
    for (const Frame& frame : frames_) {
      const bool is_array = frame.value.kind == JsonKind::array;
      if (!is_array && frame.key_line == 0) break;  // before the first key
      out += is_array ? "/" + std::to_string(frame.count) : pointer_step(frame.key);
    }
    return out;
  }

  [[noreturn]] void fail(const std::string& problem) const {
    fail_at(file_, source_.line(), pointer(), problem);
  }

  ByteSource& source_;
  const std::string& file_;
  JsonSink& sink_;
  std::vector<Frame> frames_;
  JsonDelivery delivery_ = JsonDelivery::whole;  // of the current top-level member
  std::size_t values_ = 0;                       // number of values in the current delivery
  std::uint64_t start_line_ = 1;
  bool started_ = false;
};

}  // namespace

ByteSource::ByteSource(std::istream& stream, std::string file)
    : stream_(&stream), file_(std::move(file)), block_(std::size_t{1} << 16) {}

bool ByteSource::refill() {
  if (end_was_reached_) return false;
  if (blocks_total_ - token_start_ > max_token_bytes) {
    fail_at(file_, line_, "",
            "a text or a run of blanks is longer than " + std::to_string(max_token_bytes) +
                " bytes: check that this is a JSON file");
  }
  next_ = filled_ = 0;
  load();
  end_was_reached_ = filled_ == 0;
  return !end_was_reached_;
}

/// Fills the rest of the block from the stream.
void ByteSource::load() {
  stream_->read(block_.data() + filled_, static_cast<std::streamsize>(block_.size() - filled_));
  if (stream_->bad()) {
    fail_at(file_, line_, "", "the rest of the file cannot be read: check the disk");
  }
  const auto got = static_cast<std::size_t>(stream_->gcount());
  filled_ += got;
  blocks_total_ += got;
  if (blocks_total_ > limits::max_scene_file_bytes) {
    fail_at(file_, line_, "",
            "the file is larger than " + std::to_string(limits::max_scene_file_bytes) +
                " bytes: split it");
  }
}

std::string_view ByteSource::ahead(std::size_t least) {
  if (filled_ - next_ < least && !end_was_reached_) {
    std::copy(block_.begin() + static_cast<std::ptrdiff_t>(next_),
              block_.begin() + static_cast<std::ptrdiff_t>(filled_), block_.begin());
    filled_ -= next_;
    next_ = 0;
    load();
  }
  return std::string_view(block_.data(), filled_).substr(next_);
}

void ByteSource::fail_zero_byte() const {
  fail_at(file_, line_, "", "the text contains a NUL byte: save the file as UTF-8");
}

std::uint64_t parse_json(std::istream& input, const std::string& file, JsonSink& sink) {
  ByteSource source(input, file);
  SaxHandler handler(source, file, sink);
  Json::sax_parse(ByteIterator(source), ByteIterator(), &handler);
  return handler.start_line();
}

}  // namespace parray::input
