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

/// Largest request line and header fields together, in bytes.
inline constexpr std::size_t most_head_bytes = std::size_t{64} << 10;

/// Request line and header fields (RFC 9112, sections 2 to 6).
struct RequestHead {
  std::string method;
  std::string target;  ///< from the path on, still encoded, with its query
  std::vector<std::pair<std::string, std::string>> fields;  ///< names in lower case
  std::size_t bytes = 0;                ///< of the head, its empty line included
  std::optional<std::uint64_t> length;  ///< Content-Length
  bool chunked = false;                 ///< Transfer-Encoding: chunked
  bool old = false;                     ///< HTTP/1.0
  bool closes = false;                  ///< no other request will follow on this connection
  bool expects = false;                 ///< the sender waits for "100 Continue" before its body

  /// The first field of that name, which is in lower case; "" where there is none.
  [[nodiscard]] std::string field(std::string_view name) const;
  [[nodiscard]] bool has_body() const { return chunked || length.value_or(0) > 0; }
  /// The target without its query.
  [[nodiscard]] std::string_view path() const;
};

/// The number of bytes up to and including the empty line that ends a head; none: it has not ended.
/// `searched`: so many bytes were searched before.
std::optional<std::size_t> end_of_head(std::string_view bytes, std::size_t searched);

/// Reads a whole head, `bytes` ending with its empty line. Stricter than HTTP has to be: whatever
/// two programs could read in two ways is refused. A target in absolute form, http://HOST/PATH,
/// becomes its path, and its host replaces the field Host (RFC 9112, section 3.2.2). Throws Problem
/// 400, 501 or 505.
RequestHead parse_head(std::string_view bytes);

/// The head as text, its empty line included. Leaves out the field Expect, and says Connection:
/// close where `closes` is set.
std::string text_of(const RequestHead& head);

/// Whether `text` may be the name of a header field: a token of RFC 9110, section 5.6.2.
bool is_token(std::string_view text);
/// Whether `c` may stand nowhere in a line: a control character other than a tab.
bool is_control(char c);

}  // namespace parray::http
