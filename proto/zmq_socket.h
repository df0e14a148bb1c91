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

/// What the links over ZeroMQ are made of. For their sources only.
namespace parray::proto {

/// A socket that carries messages: a ROUTER, whose peers have ids, or a DEALER. One thread.
class ZmqSocket {
 public:
  /// Tells who is behind a key; null: the connection has none.
  using Identify = std::function<Sender(const char* key)>;

  /// `linger`: how long what is not sent yet outlives the socket.
  ZmqSocket(zmq::context_t& context, zmq::socket_type type, std::size_t max_message_bytes,
            Time linger);

  zmq::socket_t& raw() { return socket_; }
  void identify_by(Identify identify) { identify_ = std::move(identify); }
  /// For whoever connects with the public key of `own`. Before it is bound.
  void serve_as(const KeyPair& own);
  /// Speaks as `own` to nobody but the owner of `server`. Before it is connected.
  void speak_as(const KeyPair& own, const std::string& server);

  /// To the first of the list; to the next when that is silent (see AddressList): what still waits
  /// for it then is dropped, as the protocol repeats it. Throws InputError when one is no address.
  void connect(AddressList addresses);

  /// As Link::send(). Throws RunError where the socket is no good.
  bool send(const PeerId& to, const Envelope& content);
  /// As Link::receive(). A message of more frames than any has is dropped as it is read, some
  /// frames a call, so that nobody else waits for its end: each call delivers a message without
  /// frames, which is none.
  std::optional<Delivery> receive();

 private:
  bool receive_part(zmq::message_t& part);
  void connect_to(const std::string& address);
  void leave_silent_address();

  zmq::socket_t socket_;
  const bool router_;
  bool dropping_ = false;  ///< the rest of a message
  const SteadyClock clock_;
  std::optional<AddressList> addresses_;  ///< of a DEALER
  OwnPeers own_peers_;
  Identify identify_ = [](const char* /*key*/) { return Sender{}; };
};

/// A file descriptor that another thread can make readable, to end a poll.
class WakeUp {
 public:
  /// Throws RunError where there is none to be had.
  WakeUp();
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;

  void raise() const noexcept;
  /// Waits until it is raised, or one of `items` has something; and begins anew.
  void poll(std::vector<zmq::pollitem_t> items, Time timeout) const;

 private:
  int fd_;
  mutable std::atomic<bool> raised_ = false;  ///< since it was polled: once is enough
};

}  // namespace parray::proto
