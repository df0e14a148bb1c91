#include "coordinator/http/chunk_decoder.h"

#include <algorithm>

#include "common/base/printable.h"
#include "common/base/text.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/request_head.h"

namespace parray::http {
namespace {

constexpr std::string_view line_end = "\r\n";
constexpr std::size_t longest_line = 1024;
constexpr std::size_t most_trailer_bytes = 8192;

[[noreturn]] void refuse(const std::string& detail) {
  throw Problem(400, "the chunked body is damaged: " + detail);
}

}  // namespace

ChunkDecoder::Step ChunkDecoder::step(std::string_view input) {
  if (phase_ == Phase::done) return {};
  if (phase_ == Phase::data) return take_data(input);
  const std::size_t end = input.substr(0, longest_line + line_end.size()).find(line_end);
  if (end == std::string_view::npos) {
    // A line of the maximum length may have arrived up to its CR, without the LF.
    if (input.size() > longest_line + 1) refuse("a line has more than 1024 bytes");
    return {};
  }
  take_line(input.substr(0, end));
  return {end + line_end.size(), {}};
}

ChunkDecoder::Step ChunkDecoder::take_data(std::string_view input) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(left_, input.size()));
  left_ -= size;
  if (left_ == 0) phase_ = Phase::data_end;
  return {size, input.substr(0, size)};
}

void ChunkDecoder::take_line(std::string_view line) {
  if (phase_ == Phase::data_end && !line.empty()) {
    refuse(
        "a chunk does not end where its size says: send the number of its bytes in hexadecimal, "
        "and do not count the CR and LF after these bytes");
  }
  if (std::ranges::any_of(line, is_control)) refuse("a line has control characters");
  if (phase_ == Phase::size) {
    take_size(line);
  } else if (phase_ == Phase::data_end) {
    phase_ = Phase::size;
  } else if (line.empty()) {
    phase_ = Phase::done;
  } else {
    trailer_bytes_ += line.size() + line_end.size();
    if (trailer_bytes_ > most_trailer_bytes) refuse("the trailer has more than 8192 bytes");
    if (!is_token(line.substr(0, line.find(':'))) || line.find(':') == std::string_view::npos) {
      refuse("'" + printable(line.substr(0, 100)) + "' is not a trailer field: send NAME: VALUE");
    }
  }
}

void ChunkDecoder::take_size(std::string_view line) {
  constexpr std::size_t most_digits = 16;
  const std::string_view digits = line.substr(0, line.find(';'));
  const std::optional<std::uint64_t> size = parsed<std::uint64_t>(digits, 16);
  if (digits.size() > most_digits || !size) {
    refuse("'" + printable(digits.substr(0, 100)) +
           "' is not a chunk size: send 1 to 16 hexadecimal digits");
  }
  left_ = *size;
  phase_ = left_ == 0 ? Phase::trailer : Phase::data;
}

}  // namespace parray::http
