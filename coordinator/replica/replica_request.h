#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "coordinator/store/replication_state.h"

/// What a primary asks of its standby, and the answers: see PROTOCOL.md, "The replica link". Each
/// is one frame that ends with the XXH3-64 of what is before.
namespace parray::replica {

enum class ReplicaRequestKind : std::uint8_t {
  ping = 1,  ///< the primary lives
  hello,     ///< a session begins: is the standby where the primary is?
  copy,      ///< forget everything: a full copy follows
  piece,     ///< bytes of the next batch, from an offset on
  commit,    ///< the batch is whole: keep it
  picture,   ///< send the picture of a job, from an offset on
};

struct ReplicaRequest {
  std::uint64_t session = 0;  ///< random; whoever is of another one is not heard
  std::uint64_t number = 0;   ///< which the answer repeats
  ReplicaRequestKind kind = ReplicaRequestKind::ping;
  Position position{};         ///< of piece and commit: that the batch leads to
  std::uint64_t offset = 0;    ///< of a piece or picture; of commit: the batch's size
  std::uint64_t checksum = 0;  ///< of commit: the batch's XXH3-64
  bool whole = false;          ///< of commit: with it the standby is where the primary is
  std::string_view bytes{};    ///< of a piece; of picture: the job's number, in digits
};

enum class ReplicaReplyKind : std::uint8_t {
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

struct ReplicaReply {
  std::uint64_t session = 0;
  std::uint64_t number = 0;
  ReplicaReplyKind kind = ReplicaReplyKind::well;
  std::uint64_t value =
      0;  ///< of have: bytes; of fenced: the generation; of picture: all its bytes
  std::string text{};
};

std::string encode(const ReplicaRequest& ask);
std::string encode(const ReplicaReply& answer);
/// `bytes` is a view of `message`. Throws DecodeError when it is none or was damaged.
ReplicaRequest decode_request(std::string_view message);
ReplicaReply decode_reply(std::string_view message);  ///< throws DecodeError

/// How much of a batch or a picture one message carries, in bytes.
inline constexpr std::size_t piece_bytes = std::size_t{4} << 20;

/// XXH3-64.
std::uint64_t checksum_of(std::string_view bytes);

}  // namespace parray::replica
