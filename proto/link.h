#pragma once

#include <optional>
#include <string>
#include <variant>

#include "proto/clock.h"
#include "proto/keys.h"
#include "proto/messages.h"

namespace parray::proto {

/// Names one other side of a link. To workers and clients the coordinator's id is empty.
/// Workers name each other, too: who asks by an id that only its answers need, who is asked by
/// peer_at().
using PeerId = std::string;

/// The worker that listens at `address`, tcp://ADDRESS:PORT, as the owner of the public key `key`.
inline PeerId peer_at(const std::string& address, const std::string& key) {
  return address + ' ' + key;
}

/// A message on its way: inside one process the message itself, else its frames.
class Envelope {
 public:
  Envelope() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a message in an envelope is still that message
  Envelope(Message message) : content_(std::move(message)) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  Envelope(Frames frames) : content_(std::move(frames)) {}

  /// The message. Throws ProtocolError when the frames are none.
  [[nodiscard]] Message open() const;
  /// Its frames; encodes where need be.
  [[nodiscard]] Frames frames() const;

 private:
  std::variant<Frames, Message> content_;
};

struct Delivery {
  PeerId peer;
  Envelope content;
  Sender sender{};  ///< of what has arrived
};

/// One end of a connection that carries messages: the seam that every transport, and every test
/// that loses messages, stands behind.
///
/// A link may lose, repeat, delay and reorder; it never blocks in send() or receive(). One thread
/// owns it; only wake() may be called from others.
class Link {
 public:
  virtual ~Link() = default;

  /// A message made ready to be sent on this link, once or several times.
  [[nodiscard]] virtual Envelope seal(Message message) const;

  /// Hands a message over for delivery. False: the peer is unknown or its queue is full, and the
  /// message is dropped.
  virtual bool send(const PeerId& to, Envelope content) = 0;

  /// The next message that has arrived, if any.
  virtual std::optional<Delivery> receive() = 0;

  /// Returns when a message is there, after wake(), or after `timeout`, whichever comes first.
  /// May return early for no reason.
  virtual void wait(Time timeout) = 0;

  /// Ends a wait(), now or the next one.
  virtual void wake() noexcept = 0;
};

}  // namespace parray::proto
