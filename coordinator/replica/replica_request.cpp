#include "coordinator/replica/replica_request.h"

#include <xxhash.h>

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

template <typename Kind>
Kind get_kind(ByteReader& reader, Kind last) {
  const auto kind = reader.get<std::uint8_t>();
  if (kind < 1 || kind > static_cast<std::uint8_t>(last)) {
    throw DecodeError("a message of no known kind");
  }
  return static_cast<Kind>(kind);
}

}  // namespace

std::uint64_t checksum_of(std::string_view bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::string encode(const ReplicaRequest& request) {
  ByteWriter writer;
  writer.reserve(request.bytes.size() + 100);
  writer.put(request_mark);
  writer.put(request.session);
  writer.put(request.number);
  writer.put(static_cast<std::uint8_t>(request.kind));
  writer.put(request.position.history);
  writer.put(request.position.generation);
  writer.put(request.position.sequence);
  writer.put(request.offset);
  writer.put(request.checksum);
  writer.put(static_cast<std::uint8_t>(request.whole ? 1 : 0));
  writer.put_bytes(request.bytes);
  return with_checksum(std::move(writer));
}

ReplicaRequest decode_request(std::string_view message) {
  ByteReader reader(checked_content(message, request_mark));
  ReplicaRequest request;
  request.session = reader.get<std::uint64_t>();
  request.number = reader.get<std::uint64_t>();
  request.kind = get_kind(reader, ReplicaRequestKind::picture);
  request.position.history = reader.get<std::uint64_t>();
  request.position.generation = reader.get<std::uint64_t>();
  request.position.sequence = reader.get<std::uint64_t>();
  request.offset = reader.get<std::uint64_t>();
  request.checksum = reader.get<std::uint64_t>();
  request.whole = reader.get<std::uint8_t>() != 0;
  request.bytes = reader.get_bytes(reader.left());
  return request;
}

std::string encode(const ReplicaReply& answer) {
  ByteWriter writer;
  writer.put(reply_mark);
  writer.put(answer.session);
  writer.put(answer.number);
  writer.put(static_cast<std::uint8_t>(answer.kind));
  writer.put(answer.value);
  writer.put_bytes(answer.text);
  return with_checksum(std::move(writer));
}

ReplicaReply decode_reply(std::string_view message) {
  ByteReader reader(checked_content(message, reply_mark));
  ReplicaReply answer;
  answer.session = reader.get<std::uint64_t>();
  answer.number = reader.get<std::uint64_t>();
  answer.kind = get_kind(reader, ReplicaReplyKind::no_picture);
  answer.value = reader.get<std::uint64_t>();
  answer.text = reader.get_bytes(reader.left());
  return answer;
}

}  // namespace parray::replica
