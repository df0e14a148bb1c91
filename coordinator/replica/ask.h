#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "coordinator/store/lineage.h"

/// What a primary asks of its standby, and the answers: see PROTOCOL.md, "The replica link". Each
/// is one frame that ends with the XXH3-64 of what is before.
namespace parray::replica {

enum class AskKind : std::uint8_t {
  ping = 1,  ///< the primary lives
  hello,     ///< a session begins: is the standby where the primary is?
  copy,      ///< forget everything: a full copy follows
  piece,     ///< bytes of the next batch, from an offset on
  commit,    ///< the batch is whole: keep it
  picture,   ///< send the picture of a job, from an offset on
};

struct Ask {
  std::uint64_t session = 0;  ///< random; whoever is of another one is not heard
  std::uint64_t number = 0;   ///< which the answer repeats
  AskKind kind = AskKind::ping;
  Position position{};         ///< of piece and commit: that the batch leads to
  std::uint64_t offset = 0;    ///< of a piece or picture; of commit: the batch's size
  std::uint64_t checksum = 0;  ///< of commit: the batch's XXH3-64
  bool whole = false;          ///< of commit: with it the standby is where the primary is
  std::string_view bytes{};    ///< of a piece; of picture: the job's number, in digits
};

enum class AnswerKind : std::uint8_t {
  well = 1,   ///< done
  who,        ///< of no session that is known: say hello
  in_step,    ///< of hello: at the same position
  behind,     ///< of hello: at another one
  have,       ///< so many bytes of the next batch are here
  committed,  ///< the batch is kept
  full,       ///< it cannot be kept now; the text says why
  fenced,     ///< a later generation serves
  refused,    ///< what is kept here is another farm's; the text says so
  picture,    ///< the text holds bytes of the picture, from the offset that was asked for
  nothing,    ///< this side has no undamaged picture of that job
};

struct Answer {
  std::uint64_t session = 0;
  std::uint64_t number = 0;
  AnswerKind kind = AnswerKind::well;
  std::uint64_t value =
      0;  ///< of have: bytes; of fenced: the generation; of picture: all its bytes
  std::string text{};
};

std::string encode(const Ask& ask);
std::string encode(const Answer& answer);
/// `bytes` is a view of `message`. Throws DecodeError when it is none or was damaged.
Ask decode_ask(std::string_view message);
Answer decode_answer(std::string_view message);  ///< throws DecodeError

/// How much of a batch or a picture one message carries, in bytes.
inline constexpr std::size_t piece_bytes = std::size_t{4} << 20;

/// XXH3-64.
std::uint64_t checksum_of(std::string_view bytes);

}  // namespace parray::replica
