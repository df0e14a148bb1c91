#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "proto/link.h"

namespace parray::proto {

/// The largest frame, in bytes, that coordinators and workers accept by default.
inline constexpr std::size_t default_max_message_bytes = std::size_t{1} << 30;

/// The largest frame, in bytes, that a client accepts. A picture of limits::max_pixels pixels with
/// its statistics and both halves has 3.5 GiB.
inline constexpr std::size_t max_answer_bytes = std::size_t{1} << 32;

/// Returns whether only this machine can reach an endpoint: tcp://127.X.X.X:*, tcp://[::1]:*,
/// tcp://localhost:*, ipc://*.
bool is_loopback(const std::string& endpoint);

/// Which peers a server with keys admits.
enum class Admits : std::uint8_t {
  members,  ///< the owners of the keys in DIR/allowed
  itself,   ///< only the owner of the coordinator's own key
};

/// A ROUTER bound to `endpoint` (tcp://ADDRESS:PORT, port * for a free one; ipc://PATH). With
/// `keys`, a directory (see keys.h), it admits only the peers that `admits` says. Without keys it
/// admits everyone. Throws RunError if it cannot be bound, InputError if the keys are unusable.
class ZmqServer {
 public:
  ZmqServer(const std::string& endpoint, std::size_t max_message_bytes,
            const std::filesystem::path& keys = {}, Admits admits = Admits::members);

  Link& link() { return *link_; }
  /// Returns the endpoint as bound, with its real port.
  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }

 private:
  std::unique_ptr<Link> link_;
  std::string endpoint_;
};

/// Returns a DEALER connected to one of `addresses`, which are separated by commas: first to the
/// first one, then to the next if the current one is silent (see AddressList). It reconnects by
/// itself when the connection breaks. The destructor waits at most `linger` for unsent messages. A
/// server with keys accepts it only with a key that the server knows. The DEALER accepts only the
/// server that its key names. Throws InputError if one of `addresses` is invalid.
std::unique_ptr<Link> zmq_connect(const std::string& addresses, std::size_t max_message_bytes,
                                  Time linger, const std::optional<MemberKey>& key = {});

/// The connections of a worker: to the coordinator, which has the empty id, and to other workers,
/// with which it shares scenes. For sharing, the process makes a pair of keys. The coordinator
/// tells the other workers the public key. With it they can be sure that they talk to this worker,
/// and all chunks are encrypted. This worker answers everyone who connects.
///
/// The worker asks one other worker at a time: send() to another one closes the connection to the
/// previous one. The destructor waits at most 1 s for unsent messages to the coordinator.
struct ZmqMesh {
  std::unique_ptr<Link> link;
  /// The port for requests of other workers; 0: none. It is on loopback if all addresses of the
  /// coordinator are, otherwise on all of this machine's addresses.
  std::uint32_t port = 0;
  std::string key;  ///< public key of the port; empty without a port
};

/// Opens the connections of a worker. `coordinator` and `key`: see zmq_connect(). `sharing`: opens
/// a port for the requests of other workers, and connects to their ports. Throws InputError if an
/// address is invalid, RunError if the port or its keys cannot be made.
ZmqMesh open_mesh(const std::string& coordinator, const std::optional<MemberKey>& key,
                  bool sharing);

}  // namespace parray::proto
