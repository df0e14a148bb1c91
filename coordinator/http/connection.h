#pragma once

#include <sys/types.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/http/file_body.h"
#include "coordinator/http/seats.h"
#include "proto/clock.h"

namespace parray::http {

/// Tells a client that waits with its body to send it (RFC 9110, section 15.2.1).
inline constexpr std::string_view continue_line = "HTTP/1.1 100 Continue\r\n\r\n";

/// Limits how long the peer of a connection may delay the transfer of bytes. It is an
/// allowance of time: waiting spends it, and transferred bytes restore it, up to `patience`. A peer
/// that stays slower than `rate` exhausts it, however evenly its bytes arrive.
class Pace {
 public:
  /// `rate`: bytes per second, > 0. Both directions of every connection must keep the default.
  explicit Pace(Time patience = seconds(10), double rate = 32768)
      : patience_(patience), rate_(rate), left_(patience) {}

  /// Subtracts time that passed without a transfer.
  void waited(Time time) { left_ -= time; }
  /// Adds the time that `bytes` take at `rate`.
  void moved(std::size_t bytes) {
    const double earned = static_cast<double>(bytes) / rate_;
    if (earned >= to_seconds(patience_ - left_)) {
      left_ = patience_;
    } else {
      left_ += from_seconds(earned);
    }
  }
  /// Restores the full allowance.
  void restart() { left_ = patience_; }

  /// Returns the time that is left, >= 0.
  [[nodiscard]] Time left() const { return std::max(left_, Time(0)); }
  /// Returns whether no time is left.
  [[nodiscard]] bool over() const { return left_ <= Time(0); }

 private:
  Time patience_;
  double rate_;
  Time left_;
};

/// A listening, non-blocking socket. The owner closes it.
struct Listener {
  int socket = -1;
  int port = 0;  ///< the bound port
};
/// Binds and listens. `port` 0 selects a free port. Returns nothing if the address cannot be bound.
std::optional<Listener> listen_at(const std::string& host, int port);

/// A new connection.
struct Arrival {
  int socket = -1;      ///< non-blocking
  std::string address;  ///< numeric IP address of the client
};
/// Accepts a connection. Returns nothing if none waits (errno EAGAIN) or accepting failed (other
/// errno).
std::optional<Arrival> accept_at(int listener);

/// One client connection: the socket, the received bytes that were not used yet, and the bytes to
/// be sent. One thread at a time owns the connection. Other threads may only call cut().
class Connection {
 public:
  /// Takes over `socket`, which must be non-blocking. `address`: the IP address of the client.
  Connection(int socket, ConnectionId id, std::string address);
  ~Connection();
  Connection& operator=(Connection&&) = delete;

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] ConnectionId id() const { return id_; }
  [[nodiscard]] const std::string& address() const { return address_; }

  /// Outcome of receiving or sending. `some`: bytes moved; `none`: the call would block; `ended`:
  /// the connection is closed or broken.
  enum class Moved { some, none, ended };
  /// Receives up to `most` bytes into input(), without waiting.
  Moved receive(std::size_t most);
  /// Like receive(), but waits for bytes. Also returns `ended` when `pace` has expired.
  Moved await_input(std::size_t most, Pace& pace);
  /// Returns the received bytes that are not consumed. The view is valid until the next receive()
  /// or consume().
  [[nodiscard]] std::string_view input() const { return std::string_view(input_).substr(used_); }
  /// Drops the first `bytes` bytes of input(), which has at least as many.
  void consume(std::size_t bytes);

  /// Stores whether input() holds a complete request, including its body.
  void set_whole(bool whole) { whole_ = whole; }
  [[nodiscard]] bool is_whole() const { return whole_; }

  /// Appends bytes to the output: a copy of `bytes`, or `part`, a part of file->bytes().
  void put(std::string_view bytes);
  void put(std::shared_ptr<const FileBody> file, std::string_view part);
  [[nodiscard]] bool has_output() const { return !output_.empty(); }
  /// Returns the bytes of memory that the output occupies. Parts of files occupy none.
  [[nodiscard]] std::size_t output_memory() const { return output_memory_; }
  /// Sends as much output as the socket accepts, and sets `bytes` to the number of bytes sent.
  /// Returns `some` if no output is left, `none` if the rest has to wait.
  Moved flush(std::size_t& bytes);
  /// Sends the whole output and waits while `pace` permits. Returns false if the connection failed
  /// or `pace` expired.
  bool await_flush(Pace& pace);

  /// Shuts the socket down in both directions. Callable from any thread.
  void cut() const;
  /// Shuts the sending direction down: the client sees the end of the answer.
  void end_output() const;

 private:
  struct Piece {
    std::string own;
    std::shared_ptr<const FileBody> file;
    std::string_view rest;  ///< bytes of `own` or `file` that were not sent yet
  };
  [[nodiscard]] ssize_t send_file() const;
  [[nodiscard]] ssize_t send_memory() const;
  void sent(std::size_t bytes);
  [[nodiscard]] bool await(short events, Pace& pace) const;

  const int socket_;
  const ConnectionId id_;
  const std::string address_;
  std::string input_;
  std::size_t used_ = 0;  ///< consumed bytes at the beginning of input_
  bool whole_ = false;
  std::deque<Piece> output_;
  std::size_t output_memory_ = 0;
};

using SharedConnection = std::shared_ptr<Connection>;

}  // namespace parray::http
