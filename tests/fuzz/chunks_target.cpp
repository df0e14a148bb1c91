#include "coordinator/http/exchange.h"
#include "coordinator/http/framing.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

namespace parray::fuzz {
namespace {

using http::ChunkDecoder;
using http::Problem;

/// What has been made of a body.
struct Decoded {
  std::string body;
  std::size_t used = 0;
  bool done = false;
  std::string refusal;  ///< empty: none
};

/// No line is longer, so that whoever reads a body never has to keep more.
constexpr std::size_t most_kept = 1025;

/// `piece`: bytes that arrive at a time.
Decoded decode(std::string_view input, std::size_t piece) {
  ChunkDecoder decoder;
  Decoded decoded;
  try {
    for (std::size_t arrived = 0; arrived < input.size() && !decoder.done();) {
      arrived = std::min(input.size(), arrived + piece);
      for (bool goes_on = true; goes_on;) {
        const std::string_view rest = input.substr(0, arrived).substr(decoded.used);
        const ChunkDecoder::Step step = decoder.step(rest);
        promise(step.used <= rest.size() && step.data.size() <= step.used, "a step in its input");
        promise(step.data.empty() || step.data.data() >= rest.data(), "data of the input");
        promise(step.used > 0 || decoder.done() || rest.size() <= most_kept, "progress");
        decoded.body += step.data;
        decoded.used += step.used;
        goes_on = step.used > 0;
      }
    }
    decoded.done = decoder.done();
    promise(!decoded.done || decoder.step("0\r\n").used == 0, "nothing behind the end");
  } catch (const Problem& problem) {
    promise(problem.status() == 400, "400 for a damaged body");
    promise_one_line(problem.what());
    decoded.refusal = problem.what();
  }
  return decoded;
}

bool run(std::string_view input) {
  const auto piece = static_cast<unsigned char>(take_letter(input));
  const Decoded whole = decode(input, input.size() + 1);
  const Decoded parts = decode(input, std::size_t{piece} + 1);
  promise(whole.body == parts.body && whole.done == parts.done && whole.used == parts.used,
          "the same body in any pieces");
  promise(whole.refusal == parts.refusal, "the same refusal in any pieces");
  return whole.done;
}

std::string in_pieces_of(char piece_less_one, std::string_view body) {
  std::string input(1, piece_less_one);
  input.append(body);
  return input;
}

std::vector<std::string> seeds() {
  std::string longest_line = "0;";
  longest_line.append(1022, 'e').append("\r\n\r\n");
  std::string long_chunk = "12C\r\n";
  long_chunk.append(300, 'x').append("\r\n00000000\r\n\r\nGET / HTTP/1.1\r\n");
  return {in_pieces_of(0, "0\r\n\r\n"), in_pieces_of(0, longest_line),
          in_pieces_of(127, long_chunk),
          in_pieces_of(5, "5\r\nhello\r\n6;name=value\r\n world\r\n0\r\nDigest: none\r\n\r\n"),
          in_pieces_of(0, "1\r\n\r\r\n1\r\n\n\r\n0;a\r\nA: \r\nB:b\r\n\r\n")};
}

}  // namespace

const Target chunks_target{"chunks", run, seeds};

}  // namespace parray::fuzz
