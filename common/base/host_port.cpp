#include "common/base/host_port.h"

#include <charconv>

namespace parray::base {

std::optional<HostPort> parse_host_port(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  HostPort parsed{text.substr(0, colon)};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, parsed.port);
  if (parsed.host.starts_with('[') && parsed.host.ends_with(']')) {
    parsed.host = parsed.host.substr(1, parsed.host.size() - 2);
  }
  const bool whole = error == std::errc() && stop == end;
  if (!whole || parsed.port < 0 || parsed.port > 65535 || parsed.host.empty()) return {};
  return parsed;
}

}  // namespace parray::base
