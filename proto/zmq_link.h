#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "proto/link.h"

namespace parray::proto {

/// Largest message that either side accepts unless told otherwise.
inline constexpr std::size_t default_max_message_bytes = std::size_t{1} << 30;

/// True for an endpoint that only this machine can reach: tcp://127.0.0.1:*, tcp://[::1]:*,
/// tcp://localhost:*, ipc://*.
bool is_loopback(const std::string& endpoint);

/// Whom a server with keys hears.
enum class Admits : std::uint8_t {
  members,  ///< whom the list names
  itself,   ///< who has the coordinator's own key
};

/// A ROUTER bound to `endpoint` (tcp://ADDRESS:PORT, port * for a free one; ipc://PATH). With
/// `keys`, a directory (see keys.h), it hears only whom `admits` says; without, anybody. Throws
/// RunError when it cannot be bound, InputError when the keys are no good.
class ZmqServer {
 public:
  ZmqServer(const std::string& endpoint, std::size_t max_message_bytes,
            const std::filesystem::path& keys = {}, Admits admits = Admits::members);
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

/// A DEALER connected to one of `addresses`, which have commas between them: the first, and the
/// next one when that is silent (see AddressList); connects again by itself when the connection
/// breaks. What is not sent when it is destroyed is dropped after `linger`. A server with keys
/// hears it with one that it knows, and it hears only the server that this names. Throws InputError
/// when one of `addresses` is none.
std::unique_ptr<Link> zmq_connect(const std::string& addresses, std::size_t max_message_bytes,
                                  Time linger, const std::optional<MemberKey>& key = {});

}  // namespace parray::proto
