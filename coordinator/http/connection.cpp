#include "coordinator/http/connection.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <utility>

namespace parray::http {
namespace {

bool must_wait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

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

Connection::Connection(int socket, ConnectionId id, std::string address)
    : socket_(socket), id_(id), address_(std::move(address)) {}

Connection::~Connection() { close(socket_); }

Connection::Moved Connection::receive(std::size_t most) {
  input_.erase(0, std::exchange(used_, 0));
  const std::size_t before = input_.size();
  input_.resize(before + most);
  const ssize_t got = recv(socket_, input_.data() + before, most, MSG_DONTWAIT);
  const bool nothing_yet = got < 0 && must_wait();
  input_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return got > 0 ? Moved::some : nothing_yet ? Moved::none : Moved::ended;
}

Connection::Moved Connection::await_input(std::size_t most, Pace& pace) {
  for (;;) {
    const std::size_t before = input().size();
    const Moved moved = receive(most);
    if (moved == Moved::some) pace.moved(input().size() - before);
    if (moved != Moved::none) return moved;
    if (!await(POLLIN, pace)) return Moved::ended;
  }
}

void Connection::consume(std::size_t bytes) {
  used_ += bytes;
  if (used_ < input_.size()) return;
  used_ = 0;
  constexpr std::size_t kept = std::size_t{1} << 14;
  if (input_.capacity() > kept) {
    input_ = {};
  } else {
    input_.clear();
  }
}

void Connection::put(std::string_view bytes) {
  if (bytes.empty()) return;
  output_.push_back({std::string(bytes), nullptr, {}});
  output_.back().rest = output_.back().own;
  output_memory_ += bytes.size();
}

void Connection::put(std::shared_ptr<const FileBody> file, std::string_view part) {
  if (!part.empty()) output_.push_back({{}, std::move(file), part});
}

Connection::Moved Connection::flush(std::size_t& bytes) {
  bytes = 0;
  while (!output_.empty()) {
    const ssize_t done = output_.front().file ? send_file() : send_memory();
    if (done < 0 && must_wait()) return Moved::none;
    if (done <= 0) return Moved::ended;
    bytes += static_cast<std::size_t>(done);
    sent(static_cast<std::size_t>(done));
  }
  return Moved::some;
}

/// Sends from the first piece, which is a file. Returns what sendfile() returns. cpp-httplib makes
/// the process ignore SIGPIPE, which sendfile() raises on a closed connection.
ssize_t Connection::send_file() const {
  constexpr std::size_t most = std::size_t{1} << 18;  // per call: others need the disk, too
  const Piece& piece = output_.front();
  auto offset = static_cast<off_t>(piece.rest.data() - piece.file->bytes().data());
  return sendfile(socket_, piece.file->descriptor(), &offset, std::min(piece.rest.size(), most));
}

/// Sends the leading pieces that are in memory. Returns what sendmsg() returns.
ssize_t Connection::send_memory() const {
  std::array<iovec, 8> parts{};
  msghdr message{};
  message.msg_iov = parts.data();
  for (const Piece& piece : output_) {
    if (message.msg_iovlen == parts.size() || piece.file) break;
    parts.at(message.msg_iovlen++) = {const_cast<char*>(piece.rest.data()), piece.rest.size()};
  }
  return sendmsg(socket_, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
}

void Connection::sent(std::size_t bytes) {
  while (bytes > 0) {
    Piece& piece = output_.front();
    const std::size_t done = std::min(bytes, piece.rest.size());
    piece.rest.remove_prefix(done);
    bytes -= done;
    if (!piece.rest.empty()) return;
    output_memory_ -= piece.own.size();
    output_.pop_front();
  }
}

bool Connection::await_flush(Pace& pace) {
  for (;;) {
    std::size_t bytes = 0;
    const Moved moved = flush(bytes);
    pace.moved(bytes);
    if (moved != Moved::none) return moved == Moved::some;
    if (!await(POLLOUT, pace)) return false;
  }
}

void Connection::cut() const { shutdown(socket_, SHUT_RDWR); }
void Connection::end_output() const { shutdown(socket_, SHUT_WR); }

/// Waits for `events` on the socket. Returns false if `pace` has expired.
bool Connection::await(short events, Pace& pace) const {
  const SteadyClock clock;
  const Time begin = clock.now();
  pollfd waiting{socket_, events, 0};
  const auto most = std::chrono::ceil<milliseconds>(pace.left()).count();
  poll(&waiting, 1, static_cast<int>(most));
  pace.waited(clock.now() - begin);
  return waiting.revents != 0 || !pace.over();
}

}  // namespace parray::http
