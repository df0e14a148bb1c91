#include "coordinator/http/listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>

namespace parray::http {
namespace {

void set(int socket, int level, int option, int value) {
  setsockopt(socket, level, option, &value, sizeof value);
}

/// Returns the listening socket, or -1 on failure.
int bind_and_listen(const addrinfo& at) {
  constexpr int backlog = 512;
  const int made = socket(at.ai_family, at.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (made < 0) return -1;
  set(made, SOL_SOCKET, SO_REUSEADDR, 1);  // not SO_REUSEPORT, which shares ports
  if (at.ai_family == AF_INET6) set(made, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  if (bind(made, at.ai_addr, at.ai_addrlen) == 0 && listen(made, backlog) == 0) return made;
  close(made);
  return -1;
}

int port_of(int socket) {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size);
  return ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(bound).sin6_port
                                           : reinterpret_cast<sockaddr_in&>(bound).sin_port);
}

}  // namespace

std::optional<Listener> listen_at(const std::string& host, int port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return {};
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(found, freeaddrinfo);
  for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
    const int socket = bind_and_listen(*at);
    if (socket >= 0) return Listener{socket, port_of(socket)};
  }
  return {};
}

std::optional<Arrival> accept_at(int listener) {
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int socket =
      accept4(listener, reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket < 0) return {};
  set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  // Limits the kernel's buffer of unsent bytes. With megabytes in the buffer the speed of the
  // client could not be measured.
  constexpr int most_unsent = 1 << 17;
  set(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, most_unsent);
  std::array<char, NI_MAXHOST> text{};
  getnameinfo(reinterpret_cast<sockaddr*>(&from), size, text.data(), text.size(), nullptr, 0,
              NI_NUMERICHOST);
  return Arrival{socket, text.data()};
}

}  // namespace parray::http
