#pragma once

#include <optional>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// A TCP host and port.
struct HostPort {
  std::string host;  ///< a name or an IP address; IPv6 without its brackets
  int port = 0;      ///< 0 .. 65535
};

/// Parses "HOST:PORT" or "[IPV6]:PORT". HOST must not contain a colon or a bracket. Returns nothing
/// if host or port is missing or invalid.
std::optional<HostPort> parse_host_port(const std::string& text);

}  // namespace parray::base
