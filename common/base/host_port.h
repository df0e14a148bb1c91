#pragma once

#include <optional>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// A host and a port of TCP.
struct HostPort {
  std::string host;  ///< a name or a number; IPv6 without its brackets
  int port = 0;      ///< 0 .. 65535
};

/// Of "HOST:PORT" or "[IPV6]:PORT"; nothing of any other text.
std::optional<HostPort> parse_host_port(const std::string& text);

}  // namespace parray::base
