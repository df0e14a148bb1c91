#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "proto/address_list.h"
#include "proto/link.h"
#include "proto/own_peers.h"

/// Building blocks of the links over ZeroMQ. Only their sources include this file.
namespace parray::proto {

/// A socket that carries messages: a ROUTER with peers that have ids, or a DEALER. Not thread-safe.
class ZmqSocket {
 public:
  /// Returns the sender that owns the public key `key` (Z85 text). Null: the connection has no key.
  using Identify = std::function<Sender(const char* key)>;

  /// `linger` is the time that unsent messages outlive the socket.
  ZmqSocket(zmq::context_t& context, zmq::socket_type type, std::size_t max_message_bytes,
            Time linger);

  zmq::socket_t& raw() { return socket_; }
  /// Uses `identify` for messages that a ROUTER receives. Until then senders have the default role.
  void identify_by(Identify identify) { identify_ = std::move(identify); }
  /// Serves peers that connect with the public key of `own`. Call it before the socket is bound.
  void serve_as(const KeyPair& own);
  /// Speaks as `own`, only to the owner of `server`. Call it before the socket is connected.
  void speak_as(const KeyPair& own, const std::string& server);

  /// Connects to the first address of the list, and to the next one if the current one is silent
  /// (see AddressList). Messages that still wait for the silent address are dropped; the protocol
  /// repeats them. Throws InputError if an address is invalid.
  void connect(AddressList addresses);

  /// Sends like Link::send(). Throws RunError if the socket is unusable.
  bool send(const PeerId& to, const Envelope& content);
  /// Receives like Link::receive(). Throws RunError if the socket is unusable. Reads at most 16
  /// frames per call; the id of the peer counts as one. So other peers need not wait for the end of
  /// an endless message. Drops a longer message in several calls. Each of them returns a message
  /// without frames, which is no valid message.
  std::optional<Delivery> receive();

 private:
  bool receive_part(zmq::message_t& part);
  void connect_to(const std::string& address);
  void leave_silent_address();

  zmq::socket_t socket_;
  const bool router_;
  bool dropping_ = false;  ///< dropping the rest of a message
  const SteadyClock clock_;
  std::optional<AddressList> addresses_;  ///< addresses of a DEALER
  OwnPeers own_peers_;
  Identify identify_ = [](const char* /*key*/) { return Sender{}; };
};

/// A file descriptor that another thread can make readable, to end a poll.
class WakeUp {
 public:
  /// Throws RunError if the system provides none.
  WakeUp();
  ~WakeUp();
  WakeUp& operator=(WakeUp&&) = delete;

  /// Ends the current or the next poll(). Any thread.
  void raise() const noexcept;
  /// Waits until raise() is called or one of `items` is ready, at most for the duration `timeout`.
  /// Returns at once if raise() was called since the last poll. A signal to the process also ends
  /// the wait. Throws RunError if an item is unusable.
  void poll(std::vector<zmq::pollitem_t> items, Time timeout) const;

 private:
  int fd_;
  mutable std::atomic<bool> raised_ = false;  ///< raised since the last poll: once is enough
};

}  // namespace parray::proto
