#include "coordinator/replica/replica_request.h"

#include "common/base/checksum.h"

namespace parray::replica {
namespace {

/// The first four bytes of requests and replies. They contain the version.
constexpr std::uint32_t request_mark = 0x01415250;  // "PRA", version 1
constexpr std::uint32_t reply_mark = 0x01425250;    // "PRB"

/// Writes or reads the numbers before the bytes: `f` is a ByteWriter or a ByteReader.
void numbers(auto& f, auto& head) {
  f.numbers(head.session, head.number, head.kind);
  if constexpr (requires { head.position; }) {  // a request
    auto& [history, generation, sequence] = head.position;
    f.numbers(history, generation, sequence, head.offset, head.checksum, head.whole);
  } else {
    f.numbers(head.value);
  }
}

std::string encoded(std::uint32_t mark, const auto& head, std::string_view bytes) {
  ByteWriter writer;
  writer.reserve(bytes.size() + 100);
  writer.put(mark);
  numbers(writer, head);
  writer.put_bytes(bytes);
  std::string message = writer.take();
  ByteWriter end;
  end.put(checksum_of(message));
  return message + end.take();
}

/// Checks mark and checksum, and reads the numbers into `head`. `last`: the last known kind.
/// Returns the bytes behind the numbers.
std::string_view decode(std::string_view message, std::uint32_t mark, auto& head, auto last) {
  if (message.size() < sizeof mark + sizeof(std::uint64_t)) throw DecodeError("data ends early");
  const std::string_view content = message.substr(0, message.size() - sizeof(std::uint64_t));
  if (ByteReader(message.substr(content.size())).get<std::uint64_t>() != checksum_of(content)) {
    throw ChecksumError("the message fails its checksum");
  }
  ByteReader reader(content);
  if (reader.get<std::uint32_t>() != mark) {
    throw DecodeError("a message of another kind or version");
  }
  numbers(reader, head);
  if (static_cast<int>(head.kind) < 1 || head.kind > last) {
    throw DecodeError("a message of no known kind");
  }
  return reader.get_bytes(reader.left());
}

}  // namespace

std::string encode(const ReplicaRequest& request) {
  return encoded(request_mark, request, request.bytes);
}

std::string encode(const ReplicaReply& answer) { return encoded(reply_mark, answer, answer.text); }

ReplicaRequest decode_request(std::string_view message) {
  ReplicaRequest request;
  request.bytes = decode(message, request_mark, request, ReplicaRequestKind::picture);
  return request;
}

ReplicaReply decode_reply(std::string_view message) {
  ReplicaReply answer;
  answer.text = decode(message, reply_mark, answer, ReplicaReplyKind::no_picture);
  return answer;
}

}  // namespace parray::replica
