#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::http {

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
