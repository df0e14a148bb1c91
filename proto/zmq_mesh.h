#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "proto/link.h"

namespace parray::proto {

/// The options of a worker's connections.
struct ZmqMeshOptions {
  std::string coordinator;  ///< addresses, separated by commas: see zmq_connect() in zmq_link.h
  std::size_t max_message_bytes = 0;  ///< largest frame from the coordinator
  /// Longest time for which the destructor waits for unsent messages to the coordinator.
  Time linger = seconds(1);
  std::optional<MemberKey> key{};  ///< key for the coordinator
  /// Whether this worker shares scenes with others: opens a port for their requests, and connects
  /// to their ports.
  bool sharing = true;
};

/// The connections of a worker: to the coordinator, which has the empty id, and to other workers,
/// with which it shares scenes. For sharing, the process makes a pair of keys. The coordinator
/// tells the other workers the public key. With it they can be sure that they talk to this worker,
/// and all chunks are encrypted. This worker answers everyone who connects.
///
/// The worker asks one other worker at a time: send() to another one closes the connection to the
/// previous one.
class ZmqMesh : public Link {
 public:
  /// Returns the port for requests of other workers; 0: none. The port is on loopback if all
  /// addresses of the coordinator are, otherwise on all of this machine's addresses.
  [[nodiscard]] virtual std::uint32_t port() const = 0;
  /// Returns the public key of the port; empty without a port.
  [[nodiscard]] virtual const std::string& key() const = 0;
};

/// Opens the connections of a worker. Throws InputError if an address is invalid, RunError if the
/// port or its keys cannot be made.
std::unique_ptr<ZmqMesh> open_mesh(const ZmqMeshOptions& options);

}  // namespace parray::proto
