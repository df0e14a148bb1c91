#pragma once

#include <map>
#include <string>

#include "common/rooms.h"

namespace parray::proto {

/// Detects connections from processes of this machine that run under this process's user. The
/// kernel supplies the facts: SO_PEERCRED for a socket file, sock_diag(7) for a loopback
/// connection. Statements of the other side do not count. A tunnel that ends on this machine under
/// the same user (ssh, kubectl port-forward) looks like such a process. Not thread-safe.
class OwnPeers {
 public:
  /// Returns whether the peer is such a process. `socket` is the socket of an accepted connection.
  /// Also returns false if the kernel gives no answer.
  bool has(int socket);

 private:
  struct Known {
    std::string peer;  ///< sockaddr of the peer; a different one means a different connection
    bool ours = false;
  };
  std::map<int, Known> known_;
};

}  // namespace parray::proto
