#pragma once

#include <optional>
#include <string>

#include "common/rooms.h"

namespace parray::http {

/// A socket that listens and does not block; whoever has it closes it.
struct Listener {
  int socket = -1;
  int port = 0;  ///< as bound
};
/// `port` 0: a free one. None: the address cannot be bound.
std::optional<Listener> listen_at(const std::string& host, int port);

/// A connection that has come.
struct Arrival {
  int socket = -1;      ///< does not block
  std::string address;  ///< of the other side, in digits
};
/// None: nobody is there (errno EAGAIN), or it failed.
std::optional<Arrival> accept_at(int listener);

}  // namespace parray::http
