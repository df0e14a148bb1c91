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

/// Returns whether `text` is a valid name of a header field: a token of RFC 9110, section 5.6.2.
bool is_token(std::string_view text);
/// Returns whether `c` is not permitted in a line: a control character other than a tab.
bool is_control(char c);

}  // namespace parray::http
