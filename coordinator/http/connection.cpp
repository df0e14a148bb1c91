#include "coordinator/http/connection.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace parray::http {
namespace {

bool must_wait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

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
}

void Connection::put(std::shared_ptr<const std::string> shared, std::string_view part) {
  if (!part.empty()) output_.push_back({{}, std::move(shared), part});
}

Connection::Moved Connection::flush(std::size_t& bytes) {
  bytes = 0;
  while (!output_.empty()) {
    std::array<iovec, 8> parts{};
    std::size_t count = 0;
    for (const Piece& piece : output_) {
      if (count == parts.size()) break;
      parts[count++] = {const_cast<char*>(piece.rest.data()), piece.rest.size()};
    }
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = count;
    const ssize_t sent = sendmsg(socket_, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) return must_wait() ? Moved::none : Moved::ended;
    bytes += static_cast<std::size_t>(sent);
    for (auto left = static_cast<std::size_t>(sent); left > 0;) {
      Piece& piece = output_.front();
      const std::size_t done = std::min(left, piece.rest.size());
      piece.rest.remove_prefix(done);
      left -= done;
      if (piece.rest.empty()) output_.pop_front();
    }
  }
  return Moved::some;
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

/// False: `pace` is over.
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
