#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/rooms.h"

namespace parray::http {

/// Limit of the request line and header fields together, in bytes.
inline constexpr std::size_t most_head_bytes = std::size_t{64} << 10;

/// Request line and header fields (RFC 9112, sections 2 to 6).
struct RequestHead {
  std::string method;
  std::string target;                                       ///< path and query, percent-encoded
  std::vector<std::pair<std::string, std::string>> fields;  ///< names in lower case
  std::size_t bytes = 0;                ///< length of the head, including its empty line
  std::optional<std::uint64_t> length;  ///< Content-Length
  bool chunked = false;                 ///< Transfer-Encoding: chunked
  bool old = false;                     ///< the version is HTTP/1.0
  bool closes = false;                  ///< no other request follows on this connection
  bool expects = false;  ///< the client waits for "100 Continue" before it sends the body

  /// Returns the first field with this name, which is in lower case; "" if it is missing.
  [[nodiscard]] std::string field(std::string_view name) const;
  [[nodiscard]] bool has_body() const { return chunked || length.value_or(0) > 0; }
  /// Returns the target without its query.
  [[nodiscard]] std::string_view path() const;
};

/// Returns the number of bytes up to and including the empty line that ends a head, or nothing if
/// the head is incomplete. `searched`: bytes that earlier calls have searched.
std::optional<std::size_t> end_of_head(std::string_view bytes, std::size_t searched);

/// Parses a complete head; `bytes` ends with its empty line. It is stricter than HTTP: it refuses
/// heads that two programs could interpret differently. A target in absolute form,
/// http://HOST/PATH, becomes its path, and its host replaces the field Host (RFC 9112, section
/// 3.2.2). Throws Problem 400, 501 or 505.
RequestHead parse_head(std::string_view bytes);

/// Returns the head as text, including its empty line. Omits the field Expect, and writes
/// Connection: close if `closes` is set.
std::string text_of(const RequestHead& head);

/// Removes the framing of a chunked body (RFC 9112, section 7.1). It is stricter than HTTP: a chunk
/// size has 1 to 16 hexadecimal digits, and every line ends with CR LF. It discards chunk
/// extensions and trailer fields. It checks the form of trailer fields, but not that of extensions.
class ChunkDecoder {
 public:
  struct Step {
    std::size_t used = 0;     ///< bytes of the input that were decoded; 0: more input is needed, or
                              ///< the body has ended
    std::string_view data{};  ///< content of the body, a part of the input; may be empty
  };
  /// Decodes one piece. `input` begins with the bytes that earlier steps have not used. Throws
  /// Problem 400 if the framing is wrong, a line is longer than 1024 bytes, or the trailer fields
  /// are longer than 8192 bytes.
  Step step(std::string_view input);
  /// Returns whether the body has ended. The bytes after it belong to the next request.
  [[nodiscard]] bool done() const { return phase_ == Phase::done; }

 private:
  enum class Phase : std::uint8_t { size, data, data_end, trailer, done };
  Step take_data(std::string_view input);
  void take_line(std::string_view line);
  void take_size(std::string_view line);

  Phase phase_ = Phase::size;
  std::uint64_t left_ = 0;         ///< bytes of the current chunk that are still to come
  std::size_t trailer_bytes_ = 0;  ///< bytes of trailer fields so far
};

}  // namespace parray::http
