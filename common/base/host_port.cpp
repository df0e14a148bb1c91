#include "common/base/host_port.h"

#include <cstdint>

#include "common/base/text.h"

namespace parray::base {

std::optional<HostPort> parse_host_port(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  HostPort named{text.substr(0, colon)};
  const bool numeric = named.host.starts_with('[') && named.host.ends_with(']');
  if (numeric) named.host = named.host.substr(1, named.host.size() - 2);
  const bool plain = named.host.find_first_of(numeric ? "[]" : "[]:") == std::string::npos;
  const auto port = parsed<std::uint16_t>(std::string_view(text).substr(colon + 1));
  if (!port || named.host.empty() || !plain) return {};
  named.port = *port;
  return named;
}

}  // namespace parray::base
