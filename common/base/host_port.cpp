#include "common/base/host_port.h"

#include "common/base/text.h"

namespace parray::base {

std::optional<HostPort> parse_host_port(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  HostPort named{text.substr(0, colon)};
  if (named.host.starts_with('[') && named.host.ends_with(']')) {
    named.host = named.host.substr(1, named.host.size() - 2);
  } else if (named.host.find(':') != std::string::npos) {
    return {};
  }
  const auto port = parsed_between(std::string_view(text).substr(colon + 1), 0, 65535);
  if (!port || named.host.empty()) return {};
  named.port = *port;
  return named;
}

}  // namespace parray::base
