#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray {

/// A message as it travels: 1 or 2 frames, see PROTOCOL.md.
using Frames = std::vector<std::string>;

/// Names one other side of a link. A worker or client has only the coordinator, whose id is empty.
using PeerId = std::string;

struct Delivery {
  PeerId peer;
  Frames frames;
};

/// One end of a connection that carries messages: the seam that every transport, and every test
/// that loses messages, stands behind.
///
/// A link may lose, repeat, delay and reorder; it never blocks in send() or receive(). One thread
/// owns it; only wake() may be called from others.
class Link {
 public:
  virtual ~Link() = default;

  /// Hands a message over for delivery. False: the peer is unknown or its queue is full, and the
  /// message is dropped.
  virtual bool send(const PeerId& to, Frames frames) = 0;

  /// The next message that has arrived, if any.
  virtual std::optional<Delivery> receive() = 0;

  /// Returns when a message is there, after wake(), or after `timeout`, whichever comes first.
  /// May return early for no reason.
  virtual void wait(Time timeout) = 0;

  /// Ends a wait(), now or the next one.
  virtual void wake() noexcept = 0;
};

}  // namespace parray
