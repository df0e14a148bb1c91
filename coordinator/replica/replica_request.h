#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "coordinator/store/replication_state.h"

/// Requests of a primary to its standby, and the replies: see PROTOCOL.md, "The replica link". Each
/// message is one frame. It ends with the XXH3-64 of all bytes before.
namespace parray::replica {

enum class ReplicaRequestKind : std::uint8_t {
  ping = 1,       ///< the primary is alive
  begin_session,  ///< `hello` in PROTOCOL.md: asks whether the standby has the primary's position
  copy,           ///< tells the standby to delete everything, because a full copy follows
  piece,          ///< carries bytes of the next batch, starting at an offset
  commit,         ///< tells the standby to commit the complete batch
  picture,        ///< asks for the picture of a job, starting at an offset
};

struct ReplicaRequest {
  /// Random number of the session. The standby replies unknown_session to any but the latest.
  std::uint64_t session = 0;
  std::uint64_t number = 0;  ///< the reply repeats it; 0: a ping
  ReplicaRequestKind kind = ReplicaRequestKind::ping;
  Position position{};         ///< piece, commit: position after the batch; else the primary's
  std::uint64_t offset = 0;    ///< piece, picture: first byte; commit: size of the batch in bytes
  std::uint64_t checksum = 0;  ///< commit: XXH3-64 of the batch
  bool whole = false;          ///< commit: the standby is in step after this batch
  std::string_view bytes{};    ///< begin_session: generations; piece: data; picture: job in digits
};

/// Names in backticks: those of PROTOCOL.md, where they differ.
enum class ReplicaReplyKind : std::uint8_t {
  done = 1,         ///< `well`: the request succeeded
  unknown_session,  ///< `who`: the primary must begin a new session
  in_step,          ///< the standby is at the primary's position
  behind,           ///< the standby is at another position and needs a full copy
  received,         ///< `have`: the standby has ReplicaReply::value bytes of the next batch
  committed,        ///< the standby has committed the batch
  full,             ///< the standby cannot commit the batch now; the text gives the reason
  fenced,           ///< another coordinator serves; ReplicaReply::value is its generation
  refused,          ///< the standby does not accept this primary; the text gives the reason
  picture,          ///< the text holds bytes of the picture from the requested offset on
  no_picture,       ///< `nothing`: the standby has no undamaged picture of the job
};

struct ReplicaReply {
  std::uint64_t session = 0;  ///< of the request
  std::uint64_t number = 0;   ///< of the request
  ReplicaReplyKind kind = ReplicaReplyKind::done;
  std::uint64_t value = 0;  ///< received: bytes; fenced: generation; picture: size of the picture
  std::string text{};
};

std::string encode(const ReplicaRequest& request);
std::string encode(const ReplicaReply& answer);
/// Decodes a request, whose `bytes` view into `message`. Throws DecodeError for a damaged message.
ReplicaRequest decode_request(std::string_view message);
ReplicaReply decode_reply(std::string_view message);  ///< throws DecodeError

/// Number of bytes of a batch or picture that one message carries at most.
inline constexpr std::size_t piece_bytes = std::size_t{4} << 20;

}  // namespace parray::replica
