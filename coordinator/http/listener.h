#pragma once

#include <optional>
#include <string>

#include "common/rooms.h"

namespace parray::http {

/// A listening, non-blocking socket. The owner closes it.
struct Listener {
  int socket = -1;
  int port = 0;  ///< the bound port
};
/// Binds and listens. `port` 0 selects a free port. Returns nothing if the address cannot be bound.
std::optional<Listener> listen_at(const std::string& host, int port);

/// A new connection.
struct Arrival {
  int socket = -1;      ///< non-blocking
  std::string address;  ///< numeric IP address of the client
};
/// Accepts a connection. Returns nothing if none waits (errno EAGAIN) or accepting failed (other
/// errno).
std::optional<Arrival> accept_at(int listener);

}  // namespace parray::http
