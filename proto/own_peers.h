#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "common/rooms.h"

namespace parray::proto {

/// Tells which connections come from processes of this machine that run under this process's user.
/// The kernel says so: SO_PEERCRED of a socket file, sock_diag(7) of a loopback connection. Nothing
/// that the other side states counts. A tunnel that ends on this machine under the same user (ssh,
/// kubectl port-forward) looks like such a process. One thread.
class OwnPeers {
 public:
  /// `socket`: of an accepted connection. False also where the kernel does not say.
  bool has(int socket);

 private:
  struct Known {
    std::string peer;  ///< its sockaddr: another one means another connection
    bool ours = false;
  };
  std::map<int, Known> known_;
};

}  // namespace parray::proto
