#pragma once

#include <optional>
#include <string>
#include <variant>

#include "proto/clock.h"
#include "proto/keys.h"
#include "proto/messages.h"

namespace parray::proto {

/// Identifies a peer of a link. For a worker or a client, the coordinator is the peer with the
/// empty id. Workers are peers of each other, too, because they share scenes. The worker that asks
/// another one identifies it by peer_at(). The other one identifies the asker by an id that serves
/// only for the answers.
using PeerId = std::string;

/// Returns the id of the worker that listens at `address`, tcp://ADDRESS:PORT, and owns the public
/// key `key`.
inline PeerId peer_at(const std::string& address, const std::string& key) {
  return address + ' ' + key;
}

/// A message on its way: the message itself inside one process, otherwise its frames.
class Envelope {
 public:
  Envelope() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a message in an envelope is still that message
  Envelope(Message message) : content_(std::move(message)) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  Envelope(Frames frames) : content_(std::move(frames)) {}

  /// Returns the message. Throws ProtocolError if the frames are not a message.
  [[nodiscard]] Message open() const;
  /// Returns the frames; encodes the message if necessary.
  [[nodiscard]] Frames frames() const;

 private:
  std::variant<Frames, Message> content_;
};

/// A message with its peer: the sender of a received message, the receiver of one to be sent.
struct Delivery {
  PeerId peer;
  Envelope content;
  /// The sender of a message to a server, which is the coordinator or a worker that shares scenes.
  /// A default Sender if the receiver is no server.
  Sender sender{};
};

/// One end of a connection that carries messages: the interface of every transport, and of every
/// test that loses messages.
///
/// A link may lose, repeat, delay and reorder messages. send() and receive() never block. One
/// thread owns a link; other threads may only call wake().
class Link {
 public:
  virtual ~Link() = default;

  /// Prepares a message for sending on this link, once or several times: encodes it if the link
  /// needs that.
  [[nodiscard]] virtual Envelope seal(Message message) const;

  /// Hands a message over for delivery. Returns false if the peer is unknown or its queue (1000
  /// messages) is full; the message is then dropped.
  virtual bool send(const PeerId& to, Envelope content) = 0;

  /// Returns the next message that has arrived, if any.
  virtual std::optional<Delivery> receive() = 0;

  /// Waits for a message or for wake(), at most for the duration `timeout`. May return early for no
  /// reason.
  virtual void wait(Time timeout) = 0;

  /// Ends the current or the next wait().
  virtual void wake() noexcept = 0;
};

}  // namespace parray::proto
