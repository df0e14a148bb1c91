#include "cli/output/preview.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <iostream>
#include <mutex>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/output/picture/image_file.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/host_port.h"
#include "common/base/printable.h"

namespace parray::output {
namespace {

using std::chrono::steady_clock;

constexpr milliseconds look_interval{100};  // how often waiting threads check for a stop request
constexpr seconds retry_interval{3};
constexpr seconds silence{10};  // time without progress after which the connection is closed

/// Message types of tev. A message has its total length as a 32-bit number, a type, a byte that
/// brings the window to the front unless it is 0, and the data of the type. All numbers are
/// little-endian, all texts end with a zero byte. Source: src/python/ipc.py of tev.
enum class Packet : std::uint8_t { create = 4, update = 6 };
constexpr std::uint32_t channel_count = 3;
constexpr std::string_view channel_names("R\0G\0B\0", 6);

std::string message_of(Packet type, std::string_view data) {
  ByteWriter message;
  message.numbers(static_cast<std::uint32_t>(data.size() + 6), type, std::uint8_t{0});
  message.put_bytes(data);
  return message.take();
}

std::string_view with_zero(const std::string& text) { return {text.c_str(), text.size() + 1}; }

std::string creation_of(const Image& image, const std::string& name) {
  ByteWriter data;
  data.put_bytes(with_zero(name));
  data.numbers(image.width, image.height, channel_count);
  data.put_bytes(channel_names);
  return message_of(Packet::create, data.take());
}

/// Returns a message with rows [begin, end).
std::string update_of(const Image& image, const std::string& name, std::uint32_t begin,
                      std::uint32_t end) {
  ByteWriter data;
  data.put_bytes(with_zero(name));
  data.put(channel_count);
  data.put_bytes(channel_names);
  data.numbers(std::uint32_t{0}, begin, image.width, end - begin);
  // The first value of each channel, and the distance of its values.
  for (const std::int64_t number : {0, 1, 2, 3, 3, 3}) data.put(number);
  const std::size_t row = std::size_t{image.width} * channel_count;
  const auto values = std::span(image.rgb).subspan(begin * row, (end - begin) * row);
  data.put_bytes({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  return message_of(Packet::update, data.take());
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

/// Shows a growing picture in a window of tev (github.com/Tom94/tev), or of another viewer with the
/// same protocol over TCP. A thread sends the pictures, so a slow or silent viewer delays nothing.
/// The first time that the viewer does not answer, the thread prints one line on stderr. After each
/// failure it tries again with the next picture, but not within three seconds.
class Display {
 public:
  /// `address`: see check_display().
  explicit Display(const std::string& address) : place_(place_of(address)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  /// Shows `image` under `name` after the previous picture was sent. Replaces a picture that still
  /// waits. Sizes may differ. Returns at once.
  void show(Image image, const std::string& name) {
    const std::lock_guard lock(mutex_);
    waiting_ = Shown{std::move(image), name};
    idle_ = false;
    changed_.notify_all();
  }

  /// Waits until the last picture was sent or could not be sent, at most `patience`.
  void finish(milliseconds patience) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] { return idle_; });
  }

 private:
  struct Shown {
    Image image;
    std::string name;
  };

  void run(const std::stop_token& stop) {
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
        std::cerr << "parray: --display: no viewer takes pictures at " +
                         printable(place_.host, 200) + ":" + std::to_string(place_.port) + " (" +
                         connection->reason() +
                         "): start tev there, or correct the address; the render continues\n";
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

  const HostPort place_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Shown> waiting_;
  bool idle_ = true;
  std::jthread thread_;  ///< last member, because the thread uses the members above
};

void check_display(const std::string& address) {
  if (!address.empty()) static_cast<void>(place_of(address));
}

bool PreviewPace::due(double elapsed, bool whole) const {
  constexpr double patience = 0.1;
  constexpr double shortest = 0.1;
  constexpr double share = 0.02;
  if (whole && !shown_whole_) return true;
  if (!latest_) return elapsed >= patience;
  return elapsed - *latest_ >= shortest && spent_ + latest_cost_ <= share * elapsed;
}

void PreviewPace::wrote(double elapsed, bool whole, double cost) {
  const bool first = !latest_ || (whole && !shown_whole_);
  spent_ += first ? 0 : cost;
  latest_cost_ = cost;
  latest_ = elapsed;
  shown_whole_ = shown_whole_ || whole;
}

Preview::Preview(const ProgressOptions& options, std::function<void()> while_writing)
    : file_(options.preview), while_writing_(std::move(while_writing)) {
  if (!options.display.empty()) display_ = std::make_unique<Display>(options.display);
}

Preview::~Preview() = default;

void Preview::follow(const Clock& clock, const JobStatus& status,
                     const std::function<Image()>& partial) {
  const bool traced = status.whole || status.samples_per_second > 0;
  if (!wanted() || status.ended() || !traced) return;
  const Time begin = clock.now();
  began_ = began_.value_or(begin);
  if (!pace_.due(to_seconds(begin - *began_), status.whole)) return;
  Image image = partial();
  if (!file_.empty()) write_preview(file_, image, while_writing_);
  if (display_) display_->show(std::move(image), name_ = status.name);
  const Time end = clock.now();
  pace_.wrote(to_seconds(end - *began_), status.whole, to_seconds(end - begin));
}

void Preview::finish(const Image& image) {
  if (!display_ || name_.empty()) return;
  display_->show(image, name_);
  display_->finish(seconds(2));
}

}  // namespace parray::output
