#pragma once

#include <iterator>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "proto/keys.h"
#include "proto/messages.h"
#include "tests/support/rooms.h"

namespace parray {

/// One connection to a coordinator, without the retries of a real client. One thread.
class Peer {
 public:
  Peer(zmq::context_t& context, const std::string& address, const std::optional<MemberKey>& key)
      : socket_(context, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::linger, 0);
    if (key) {
      socket_.set(zmq::sockopt::curve_serverkey, key->coordinator);
      socket_.set(zmq::sockopt::curve_publickey, key->own.open);
      socket_.set(zmq::sockopt::curve_secretkey, key->own.secret);
    }
    socket_.connect(address);
  }
  void send(const Message& message) {
    std::vector<zmq::message_t> parts;
    for (const Frame& frame : encode(message)) {
      parts.emplace_back(frame.view().data(), frame.size());
    }
    zmq::send_multipart(socket_, parts);
  }
  /// What has arrived; nothing: no message has.
  std::optional<Message> receive() {
    std::vector<zmq::message_t> parts;
    if (!zmq::recv_multipart(socket_, std::back_inserter(parts), zmq::recv_flags::dontwait)) {
      return {};
    }
    Frames frames;
    for (const zmq::message_t& part : parts) frames.emplace_back(part.to_string());
    return decode(frames);
  }
  void* handle() { return socket_.handle(); }

 private:
  zmq::socket_t socket_;
};

/// The key that DIR/NAME.key holds; nothing where `keys` is empty. Throws InputError.
inline std::optional<MemberKey> key_of(const std::string& keys, const std::string& name) {
  return keys.empty() ? std::nullopt : std::optional(read_member_key(keys, name));
}

}  // namespace parray
