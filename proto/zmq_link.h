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

}  // namespace parray::proto
