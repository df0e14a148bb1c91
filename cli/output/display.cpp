#include "cli/output/display.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::output {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr milliseconds look_interval{100};  // how often waiting threads check for a stop request
constexpr seconds retry_interval{3};
constexpr seconds silence{10};  // time without progress after which the connection is closed

/// Message types of tev. A message has its total length as a 32-bit number, a type, and the data of
/// the type. All numbers are little-endian, all texts end with a zero byte. Source:
/// src/python/ipc.py of tev.
enum class Packet : std::uint8_t { create = 4, update = 6 };
constexpr std::array<std::string_view, 3> channel_names{"R", "G", "B"};

class Message {
 public:
  explicit Message(Packet type) {
    out_.put(std::uint32_t{0});
    out_.put(static_cast<std::uint8_t>(type));
    out_.put(std::uint8_t{0});  // the window does not come to the front
  }
  void text(std::string_view text) {
    out_.put_bytes(text);
    out_.put(std::uint8_t{0});
  }
  void number(auto value) { out_.put(value); }
  void values(std::span<const float> values) {
    out_.put_bytes({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  }
  std::string take() {
    std::string bytes = out_.take();
    const auto size = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(bytes.data(), &size, sizeof size);
    return bytes;
  }

 private:
  static_assert(std::endian::native == std::endian::little);
  ByteWriter out_;
};

std::string creation_of(const Image& image, const std::string& name) {
  Message message(Packet::create);
  message.text(name);
  message.number(static_cast<std::int32_t>(image.width));
  message.number(static_cast<std::int32_t>(image.height));
  message.number(static_cast<std::int32_t>(channel_names.size()));
  for (const std::string_view channel : channel_names) message.text(channel);
  return message.take();
}

/// Returns a message with rows [begin, end).
std::string update_of(const Image& image, const std::string& name, std::uint32_t begin,
                      std::uint32_t end) {
  Message message(Packet::update);
  message.text(name);
  constexpr auto channels = static_cast<std::int32_t>(channel_names.size());
  message.number(channels);
  for (const std::string_view channel : channel_names) message.text(channel);
  for (const std::uint32_t value : {0U, begin, image.width, end - begin}) {
    message.number(static_cast<std::int32_t>(value));
  }
  for (std::int64_t channel = 0; channel < channels; ++channel) message.number(channel);
  for (std::int64_t channel = 0; channel < channels; ++channel) {
    message.number(std::int64_t{channels});
  }
  const std::size_t row = std::size_t{image.width} * channel_names.size();
  message.values(std::span(image.rgb).subspan(begin * row, (end - begin) * row));
  return message.take();
}

/// A connection whose calls return soon after a stop request.
class Connection {
 public:
  Connection(const HostPort& place, const std::stop_token& stop) : stop_(stop) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int error =
            ::getaddrinfo(place.host.c_str(), std::to_string(place.port).c_str(), &hints, &found);
        error != 0) {
      reason_ = ::gai_strerror(error);
      return;
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
    for (const addrinfo* at = found; at != nullptr && !open(); at = at->ai_next) connect(*at);
  }
  ~Connection() { close(); }
  Connection& operator=(Connection&&) = delete;

  [[nodiscard]] bool open() const { return socket_ >= 0; }
  [[nodiscard]] const std::string& reason() const { return reason_; }

  /// Sends all bytes. Returns false if the connection failed; it is closed then.
  bool send(std::string_view bytes) {
    while (!bytes.empty() && open()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent > 0) {
        bytes.remove_prefix(static_cast<std::size_t>(sent));
      } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
        if (!ready(silence)) fail("a program took the connection but no data for 10 s");
      } else if (errno != EINTR) {
        fail(text_of(errno));
      }
    }
    return open();
  }

 private:
  static std::string text_of(int error) { return std::generic_category().message(error); }

  void connect(const addrinfo& to) {
    socket_ = ::socket(to.ai_family, to.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, to.ai_protocol);
    if (!open()) return fail(text_of(errno));
    if (::connect(socket_, to.ai_addr, to.ai_addrlen) == 0) return;
    if (errno != EINPROGRESS) return fail(text_of(errno));
    int error = ETIMEDOUT;
    socklen_t size = sizeof error;
    if (ready(seconds(5))) ::getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) fail(text_of(error));
  }

  /// Waits until the socket accepts data, at most `patience`. Returns whether it does.
  bool ready(milliseconds patience) const {
    const auto until = steady_clock::now() + patience;
    while (!stop_.stop_requested() && steady_clock::now() < until) {
      pollfd poll{socket_, POLLOUT, 0};
      if (::poll(&poll, 1, static_cast<int>(look_interval.count())) > 0) return true;
    }
    return false;
  }

  void fail(const std::string& reason) {
    reason_ = reason;
    close();
  }
  void close() {
    if (open()) ::close(socket_);
    socket_ = -1;
  }

  std::stop_token stop_;
  int socket_ = -1;
  std::string reason_;
};

bool send_picture(Connection& connection, const Image& image, const std::string& name,
                  bool create) {
  if (create && !connection.send(creation_of(image, name))) return false;
  constexpr std::uint32_t most_values = 1 << 18;  // one megabyte per message
  const std::uint32_t rows = std::max(1U, most_values / (3 * image.width));
  for (std::uint32_t y = 0; y < image.height; y += rows) {
    if (!connection.send(update_of(image, name, y, std::min(y + rows, image.height)))) return false;
  }
  return true;
}

HostPort place_of(const std::string& address) {
  const auto place = parse_host_port(address);
  if (place && place->port > 0) return *place;
  throw InputError(
      "--display " + printable(address, 200) +
      ": give the host and port of the viewer, such as 127.0.0.1:14158 or [::1]:14158");
}

}  // namespace

Display::Display(const std::string& address) : place_(place_of(address)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Display::check(const std::string& address) {
  if (!address.empty()) static_cast<void>(place_of(address));
}

Display::~Display() = default;

void Display::show(Image image, const std::string& name) {
  const std::lock_guard lock(mutex_);
  waiting_ = Shown{std::move(image), name};
  idle_ = false;
  changed_.notify_all();
}

void Display::finish(milliseconds patience) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience, [this] { return idle_; });
}

void Display::run(const std::stop_token& stop) {
  std::unique_ptr<Connection> connection;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> created;
  std::string created_name;
  bool said = false;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return waiting_.has_value(); })) {
    const Shown shown = *std::exchange(waiting_, std::nullopt);
    lock.unlock();
    if (!connection || !connection->open()) {
      connection = std::make_unique<Connection>(place_, stop);
      created.reset();
    }
    const std::pair size(shown.image.width, shown.image.height);
    const bool create = created != size || created_name != shown.name;
    const bool sent =
        connection->open() && send_picture(*connection, shown.image, shown.name, create);
    if (sent) {
      created = size;
      created_name = shown.name;
    } else if (!std::exchange(said, true) && !stop.stop_requested()) {
      std::cerr << "parray: --display: no viewer takes pictures at " + printable(place_.host, 200) +
                       ":" + std::to_string(place_.port) + " (" + connection->reason() +
                       "): start tev there again, or correct the address; the render continues\n";
    }
    lock.lock();
    if (!sent) {
      // finish() must not wait: only a newer picture can be sent now.
      idle_ = true;
      changed_.notify_all();
      changed_.wait_for(lock, stop, retry_interval, [] { return false; });
    }
    idle_ = !waiting_;
    changed_.notify_all();
  }
}

}  // namespace parray::output
