#include "proto/stream_frames.h"

#include <sys/socket.h>

#include <cerrno>
#include <string>
#include <utility>
#include <vector>

namespace parray::proto {
namespace {

constexpr std::uint32_t most_frames = 16;

bool send_all(int socket, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket, bytes, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t got = recv(socket, bytes, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

bool send_number(int socket, auto number) {
  return send_all(socket, reinterpret_cast<const char*>(&number), sizeof number);
}

bool receive_number(int socket, auto& number) {
  return receive_all(socket, reinterpret_cast<char*>(&number), sizeof number);
}

}  // namespace

bool write_frames(int socket, const Frames& frames) {
  bool good = send_number(socket, static_cast<std::uint32_t>(frames.size()));
  for (const Frame& frame : frames) good = good && send_number(socket, std::uint64_t{frame.size()});
  for (const Frame& frame : frames) {
    good = good && send_all(socket, frame.view().data(), frame.size());
  }
  return good;
}

std::optional<Frames> read_frames(int socket, std::uint64_t most_bytes) {
  std::uint32_t count = 0;
  if (!receive_number(socket, count) || count > most_frames) return {};
  std::vector<std::uint64_t> sizes(count);
  for (std::uint64_t& size : sizes) {
    if (!receive_number(socket, size) || size > most_bytes) return {};
    most_bytes -= size;
  }
  Frames frames;
  for (const std::uint64_t size : sizes) {
    std::string bytes(size, '\0');
    if (!receive_all(socket, bytes.data(), size)) return {};
    frames.emplace_back(std::move(bytes));
  }
  return frames;
}

}  // namespace parray::proto
