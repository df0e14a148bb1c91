#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "proto/link.h"

namespace parray {

/// Largest message that either side accepts unless told otherwise.
inline constexpr std::size_t default_max_message_bytes = std::size_t{1} << 30;

/// True for an endpoint that only this machine can reach: tcp://127.0.0.1:*, tcp://[::1]:*,
/// tcp://localhost:*, ipc://*.
bool is_loopback(const std::string& endpoint);

/// A ROUTER bound to `endpoint` (tcp://ADDRESS:PORT, port * for a free one; ipc://PATH). With
/// `keys`, a directory (see keys.h), it hears only whom the list there names; without, anybody.
/// Throws RunError when it cannot be bound, InputError when the keys are no good.
class ZmqServer {
 public:
  ZmqServer(const std::string& endpoint, std::size_t max_message_bytes,
            const std::filesystem::path& keys = {});
  ~ZmqServer();
  ZmqServer(const ZmqServer&) = delete;
  ZmqServer& operator=(const ZmqServer&) = delete;

  Link& link();
  /// The endpoint as bound, with its real port.
  [[nodiscard]] const std::string& endpoint() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// A DEALER connected to `endpoint`; connects again by itself when the connection breaks. What is
/// not sent when it is destroyed is dropped after `linger`. A server with keys hears it with one
/// that it knows, and it hears only the server that this names.
/// Throws InputError when `endpoint` is not one.
std::unique_ptr<Link> zmq_connect(const std::string& endpoint, std::size_t max_message_bytes,
                                  Time linger, const std::optional<MemberKey>& key = {});

}  // namespace parray
