#include "coordinator/http/framing.h"

#include <algorithm>

#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "coordinator/http/exchange.h"

namespace parray::http {
namespace {

constexpr std::string_view line_break = "\r\n";
// Limits of a chunked body, in bytes.
constexpr std::size_t longest_line = 1024;
constexpr std::size_t most_trailer_bytes = 8192;

/// Returns whether `text` is a valid name of a header field: a token of RFC 9110, section 5.6.2.
bool is_token(std::string_view text) {
  constexpr std::string_view marks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return ascii::is_letter_or_digit(c) || marks.find(c) != std::string_view::npos;
  });
}

/// Returns whether `c` is not permitted in a line: a control character other than a tab.
bool is_control(char c) { return (c >= 0 && c < ' ' && c != '\t') || c == '\x7f'; }

[[noreturn]] void refuse_head(const std::string& detail) { throw Problem(400, detail); }

[[noreturn]] void refuse_chunk(const std::string& detail) {
  throw Problem(400, "the chunked body is damaged: " + detail);
}

void parse_request_line(std::string_view line, RequestHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  const bool three = first != std::string_view::npos && first < last;
  if (!three || !is_token(line.substr(0, first)) ||
      line.substr(first + 1, last - first - 1).find(' ') != std::string_view::npos) {
    refuse_head("'" + printable(line.substr(0, 100)) +
                "' is not a request line: send METHOD TARGET HTTP/1.1");
  }
  const std::string_view version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    throw Problem(505,
                  "'" + printable(version.substr(0, 20)) + "' is not supported: send HTTP/1.1");
  }
  head.old = version == "HTTP/1.0";
  head.closes = head.old;
  head.method = line.substr(0, first);
  head.target = line.substr(first + 1, last - first - 1);
}

void parse_field(std::string_view line, RequestHead& head) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
    refuse_head("'" + printable(line.substr(0, 100)) + "' is not a header field: send NAME: VALUE");
  }
  head.fields.emplace_back(lower_case(line.substr(0, colon)), trimmed(line.substr(colon + 1)));
}

std::uint64_t parse_length(const std::string& text) {
  const std::optional<std::uint64_t> value = natural_in(text);
  if (!value) {
    refuse_head("Content-Length: '" + printable(text) +
                "' is not a number of bytes: send decimal digits, below 2^64");
  }
  return *value;
}

/// Finds out how the body is delimited (RFC 9112, section 6).
void find_body(RequestHead& head) {
  for (const auto& [name, value] : head.fields) {
    if (name == "content-length") {
      if (head.length) refuse_head("Content-Length occurs twice: send it once");
      head.length = parse_length(value);
    } else if (name == "transfer-encoding") {
      if (head.chunked) refuse_head("Transfer-Encoding occurs twice: send it once");
      if (lower_case(value) != "chunked") {
        throw Problem(501, "Transfer-Encoding: '" + printable(value) +
                               "' is not supported: send chunked, or a Content-Length");
      }
      head.chunked = true;
    }
  }
  if (head.chunked && head.old) {
    refuse_head("HTTP/1.0 has no Transfer-Encoding: send a Content-Length");
  }
  if (head.chunked && head.length) {
    refuse_head("Content-Length and Transfer-Encoding exclude each other: send one of them");
  }
}

/// Removes the authority from a target in absolute form (RFC 9112, section 3.2.2) and returns it.
/// Returns "" if the target has another form.
std::string take_authority(std::string& target) {
  constexpr std::string_view mark = "://";
  const std::size_t colon = target.find(mark);
  if (colon == std::string::npos) return "";
  const std::string scheme = lower_case(std::string_view(target).substr(0, colon));
  if (scheme != "http" && scheme != "https") return "";
  const std::size_t begin = colon + mark.size();
  const std::size_t end = std::min(target.find_first_of("/?", begin), target.size());
  std::string authority = target.substr(begin, end - begin);
  if (authority.find('@') != std::string::npos) {
    refuse_head("the URL of the request contains a user name: send http://HOST/PATH");
  }
  if (authority.empty()) {
    refuse_head("'" + printable(target, 200) + "' contains no host: send http://HOST/PATH");
  }
  target.erase(0, end);
  if (!target.starts_with('/')) target.insert(0, "/");
  return authority;
}

/// Checks that there is at most one host. The target's host replaces the field (RFC 9112, section
/// 3.2).
void find_host(RequestHead& head) {
  constexpr auto is_host = [](const auto& field) { return field.first == "host"; };
  if (std::ranges::count_if(head.fields, is_host) > 1) {
    refuse_head("Host occurs twice: send it once");
  }
  const std::string authority = take_authority(head.target);
  if (authority.empty()) return;
  std::erase_if(head.fields, is_host);
  head.fields.emplace_back("host", authority);
}

/// Returns whether a field Connection contains the option close (RFC 9110, section 7.6.1).
bool wants_close(const RequestHead& head) {
  return std::ranges::any_of(head.fields, [](const auto& field) {
    return field.first == "connection" &&
           std::ranges::any_of(split_at(',', field.second), [](std::string_view option) {
             return lower_case(trimmed(option)) == "close";
           });
  });
}

}  // namespace

std::string text_of(const RequestHead& head) {
  std::string text = head.method + " " + head.target + (head.old ? " HTTP/1.0" : " HTTP/1.1");
  text += line_break;
  if (head.closes) text += "connection: close\r\n";
  for (const auto& [name, value] : head.fields) {
    const bool replaced = name == "expect" || (name == "connection" && head.closes);
    if (!replaced) text += name + ": " + value + "\r\n";
  }
  return text += line_break;
}

std::string RequestHead::field(std::string_view name) const {
  const auto found = std::ranges::find(
      fields, name, [](const auto& entry) -> std::string_view { return entry.first; });
  return found == fields.end() ? "" : found->second;
}

std::string_view RequestHead::path() const {
  return std::string_view(target).substr(0, std::min(target.find('?'), target.size()));
}

std::optional<std::size_t> end_of_head(std::string_view bytes, std::size_t searched) {
  constexpr std::string_view end = "\r\n\r\n";
  const std::size_t from = searched < end.size() ? 0 : searched - (end.size() - 1);
  const std::size_t found = bytes.find(end, from);
  return found == std::string_view::npos ? std::nullopt : std::optional(found + end.size());
}

RequestHead parse_head(std::string_view bytes) {
  RequestHead head;
  head.bytes = bytes.size();
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find(line_break, begin), bytes.size());
    const std::string_view line = bytes.substr(begin, end - begin);
    if (std::ranges::any_of(line, is_control)) {
      refuse_head("the head of the request contains control characters: remove them");
    }
    if (begin == 0) {
      parse_request_line(line, head);
    } else if (!line.empty()) {
      parse_field(line, head);
    }
    begin = end + line_break.size();
  }
  find_host(head);
  find_body(head);
  head.expects = !head.old && lower_case(head.field("expect")) == "100-continue";
  head.closes = head.closes || wants_close(head);
  return head;
}

ChunkDecoder::Step ChunkDecoder::step(std::string_view input) {
  if (phase_ == Phase::done) return {};
  if (phase_ == Phase::data) return take_data(input);
  const std::size_t end = input.substr(0, longest_line + line_break.size()).find(line_break);
  if (end == std::string_view::npos) {
    // A line of the maximum length may have arrived up to its CR, without the LF.
    if (input.size() > longest_line + 1) refuse_chunk("a line has more than 1024 bytes");
    return {};
  }
  take_line(input.substr(0, end));
  return {end + line_break.size(), {}};
}

ChunkDecoder::Step ChunkDecoder::take_data(std::string_view input) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(left_, input.size()));
  left_ -= size;
  if (left_ == 0) phase_ = Phase::data_end;
  return {size, input.substr(0, size)};
}

void ChunkDecoder::take_line(std::string_view line) {
  if (phase_ == Phase::data_end && !line.empty()) {
    refuse_chunk(
        "a chunk does not end where its size says: send the number of its bytes in hexadecimal, "
        "and do not count the CR and LF after these bytes");
  }
  if (std::ranges::any_of(line, is_control)) refuse_chunk("a line has control characters");
  if (phase_ == Phase::size) {
    take_size(line);
  } else if (phase_ == Phase::data_end) {
    phase_ = Phase::size;
  } else if (line.empty()) {
    phase_ = Phase::done;
  } else {
    trailer_bytes_ += line.size() + line_break.size();
    if (trailer_bytes_ > most_trailer_bytes) refuse_chunk("the trailer has more than 8192 bytes");
    if (!is_token(line.substr(0, line.find(':'))) || line.find(':') == std::string_view::npos) {
      refuse_chunk("'" + printable(line.substr(0, 100)) +
                   "' is not a trailer field: send NAME: VALUE");
    }
  }
}

void ChunkDecoder::take_size(std::string_view line) {
  constexpr std::size_t most_digits = 16;
  const std::string_view digits = line.substr(0, line.find(';'));
  const std::optional<std::uint64_t> size = parsed<std::uint64_t>(digits, 16);
  if (digits.size() > most_digits || !size) {
    refuse_chunk("'" + printable(digits.substr(0, 100)) +
                 "' is not a chunk size: send 1 to 16 hexadecimal digits");
  }
  left_ = *size;
  phase_ = left_ == 0 ? Phase::trailer : Phase::data;
}

}  // namespace parray::http
