#include "coordinator/replica/replica_request.h"

#include <xxhash.h>

namespace parray::replica {
namespace {

/// What tells the two from each other, and from those of another version.
constexpr std::uint32_t ask_mark = 0x01415250;     // "PRA", version 1
constexpr std::uint32_t answer_mark = 0x01425250;  // "PRB"

std::string sealed(ByteWriter writer) {
  std::string message = writer.take();
  ByteWriter end;
  end.put(checksum_of(message));
  return message + end.take();
}

/// Without its end, which is checked.
std::string_view opened(std::string_view message, std::uint32_t mark) {
  if (message.size() < sizeof mark + sizeof(std::uint64_t)) {
    throw DecodeError("data ends early");
  }
  const std::string_view content = message.substr(0, message.size() - sizeof(std::uint64_t));
  ByteReader end(message.substr(content.size()));
  if (end.get<std::uint64_t>() != checksum_of(content)) {
    throw ChecksumError("the message was damaged");
  }
  ByteReader begin(content);
  if (begin.get<std::uint32_t>() != mark) {
    throw DecodeError("a message of another kind or version");
  }
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

std::string encode(const ReplicaRequest& ask) {
  ByteWriter writer;
  writer.reserve(ask.bytes.size() + 100);
  writer.put(ask_mark);
  writer.put(ask.session);
  writer.put(ask.number);
  writer.put(static_cast<std::uint8_t>(ask.kind));
  writer.put(ask.position.history);
  writer.put(ask.position.generation);
  writer.put(ask.position.sequence);
  writer.put(ask.offset);
  writer.put(ask.checksum);
  writer.put(static_cast<std::uint8_t>(ask.whole ? 1 : 0));
  writer.put_bytes(ask.bytes);
  return sealed(std::move(writer));
}

ReplicaRequest decode_request(std::string_view message) {
  ByteReader reader(opened(message, ask_mark));
  ReplicaRequest ask;
  ask.session = reader.get<std::uint64_t>();
  ask.number = reader.get<std::uint64_t>();
  ask.kind = get_kind(reader, ReplicaRequestKind::picture);
  ask.position.history = reader.get<std::uint64_t>();
  ask.position.generation = reader.get<std::uint64_t>();
  ask.position.sequence = reader.get<std::uint64_t>();
  ask.offset = reader.get<std::uint64_t>();
  ask.checksum = reader.get<std::uint64_t>();
  ask.whole = reader.get<std::uint8_t>() != 0;
  ask.bytes = reader.get_bytes(reader.left());
  return ask;
}

std::string encode(const ReplicaReply& answer) {
  ByteWriter writer;
  writer.put(answer_mark);
  writer.put(answer.session);
  writer.put(answer.number);
  writer.put(static_cast<std::uint8_t>(answer.kind));
  writer.put(answer.value);
  writer.put_bytes(answer.text);
  return sealed(std::move(writer));
}

ReplicaReply decode_reply(std::string_view message) {
  ByteReader reader(opened(message, answer_mark));
  ReplicaReply answer;
  answer.session = reader.get<std::uint64_t>();
  answer.number = reader.get<std::uint64_t>();
  answer.kind = get_kind(reader, ReplicaReplyKind::nothing);
  answer.value = reader.get<std::uint64_t>();
  answer.text = reader.get_bytes(reader.left());
  return answer;
}

}  // namespace parray::replica
