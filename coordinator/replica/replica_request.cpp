#include "coordinator/replica/replica_request.h"

#include "common/base/checksum.h"

namespace parray::replica {
namespace {

/// The first four bytes of requests and replies. They contain the version.
constexpr std::uint32_t request_mark = 0x01415250;  // "PRA", version 1
constexpr std::uint32_t reply_mark = 0x01425250;    // "PRB"

std::string with_checksum(ByteWriter writer) {
  std::string message = writer.take();
  ByteWriter end;
  end.put(checksum_of(message));
  return message + end.take();
}

/// Checks mark and checksum and returns the bytes between them.
std::string_view checked_content(std::string_view message, std::uint32_t mark) {
  if (message.size() < sizeof mark + sizeof(std::uint64_t)) throw DecodeError("data ends early");
  const std::string_view content = message.substr(0, message.size() - sizeof(std::uint64_t));
  ByteReader end(message.substr(content.size()));
  if (end.get<std::uint64_t>() != checksum_of(content)) {
    throw ChecksumError("the message fails its checksum");
  }
  ByteReader begin(content);
  if (begin.get<std::uint32_t>() != mark) throw DecodeError("a message of another kind or version");
  return content.substr(sizeof mark);
}

// The numbers before the bytes, for both directions: `f` is a ByteWriter or a ByteReader.

void request_numbers(auto& f, auto& request) {
  auto& [history, generation, sequence] = request.position;
  f.numbers(request.session, request.number, request.kind, history, generation, sequence,
            request.offset, request.checksum, request.whole);
}

void reply_numbers(auto& f, auto& reply) {
  f.numbers(reply.session, reply.number, reply.kind, reply.value);
}

void check_kind(auto kind, auto last) {
  if (static_cast<int>(kind) < 1 || kind > last) throw DecodeError("a message of no known kind");
}

}  // namespace

std::string encode(const ReplicaRequest& request) {
  ByteWriter writer;
  writer.reserve(request.bytes.size() + 100);
  writer.put(request_mark);
  request_numbers(writer, request);
  writer.put_bytes(request.bytes);
  return with_checksum(std::move(writer));
}

ReplicaRequest decode_request(std::string_view message) {
  ByteReader reader(checked_content(message, request_mark));
  ReplicaRequest request;
  request_numbers(reader, request);
  check_kind(request.kind, ReplicaRequestKind::picture);
  request.bytes = reader.get_bytes(reader.left());
  return request;
}

std::string encode(const ReplicaReply& answer) {
  ByteWriter writer;
  writer.put(reply_mark);
  reply_numbers(writer, answer);
  writer.put_bytes(answer.text);
  return with_checksum(std::move(writer));
}

ReplicaReply decode_reply(std::string_view message) {
  ByteReader reader(checked_content(message, reply_mark));
  ReplicaReply answer;
  reply_numbers(reader, answer);
  check_kind(answer.kind, ReplicaReplyKind::no_picture);
  answer.text = reader.get_bytes(reader.left());
  return answer;
}

}  // namespace parray::replica
