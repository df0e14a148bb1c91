#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::http {

/// Takes the framing off a chunked body (RFC 9112, section 7.1). Stricter than HTTP has to be: a
/// chunk size is 1 to 16 hexadecimal digits, and every line ends with CR LF. Extensions of a chunk
/// and trailer fields are checked and dropped.
class ChunkDecoder {
 public:
  struct Step {
    std::size_t used = 0;     ///< bytes of the input; 0: more input is needed, or the body is over
    std::string_view data{};  ///< content of the body, a part of the input; may be empty
  };
  /// Decodes from the beginning of `input`, which holds what earlier steps have not used. Throws
  /// Problem 400 when the framing is wrong or a line is too long.
  Step step(std::string_view input);
  /// Whether the body is over: what follows belongs to the next request.
  [[nodiscard]] bool done() const { return phase_ == Phase::done; }

 private:
  enum class Phase : std::uint8_t { size, data, data_end, trailer, done };
  Step take_data(std::string_view input);
  void take_line(std::string_view line);
  void take_size(std::string_view line);

  Phase phase_ = Phase::size;
  std::uint64_t left_ = 0;         ///< bytes of the chunk
  std::size_t trailer_bytes_ = 0;  ///< so far
};

}  // namespace parray::http
