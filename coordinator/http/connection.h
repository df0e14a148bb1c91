#pragma once

#include <sys/types.h>

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <string_view>

#include "coordinator/http/file_body.h"
#include "coordinator/http/pace.h"
#include "coordinator/http/seats.h"

namespace parray::http {

/// Tells who waits for it that the body may come (RFC 9110, section 15.2.1).
inline constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";

/// One connection: its socket, what has come and was not used yet, and what is still to be sent.
/// Whoever has it at the time uses it; only cut() may be called by another thread meanwhile.
class Connection {
 public:
  /// Takes over `socket`, which does not block. `address`: of the other side.
  Connection(int socket, ConnectionId id, std::string address);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] ConnectionId id() const { return id_; }
  [[nodiscard]] const std::string& address() const { return address_; }

  enum class Moved { some, none, ended };
  /// Takes what has come, `most` bytes at most. `ended`: no more will come.
  Moved receive(std::size_t most);
  /// As receive(), but waits for what is due. `ended` also when `pace` is over.
  Moved await_input(std::size_t most, Pace& pace);
  [[nodiscard]] std::string_view input() const { return std::string_view(input_).substr(used_); }
  /// The first `bytes` of input() are used.
  void consume(std::size_t bytes);

  /// Whether input() holds a whole request, its body included, when it is handed over.
  void set_whole(bool whole) { whole_ = whole; }
  [[nodiscard]] bool is_whole() const { return whole_; }

  /// Appends to what is to be sent: a copy, or a part of a file.
  void put(std::string_view bytes);
  void put(std::shared_ptr<const FileBody> file, std::string_view part);
  [[nodiscard]] bool has_output() const { return !output_.empty(); }
  /// Bytes of memory that wait to be sent.
  [[nodiscard]] std::size_t output_memory() const { return output_memory_; }
  /// Sends what the other side takes now. `bytes`: so many. `some`: all is sent; `none`: the rest
  /// has to wait.
  Moved flush(std::size_t& bytes);
  /// Sends everything, and waits for as long as `pace` lets it. False: the other side is gone.
  bool await_flush(Pace& pace);

  /// No more is received or sent. Any thread.
  void cut() const;
  /// Nothing follows what was sent.
  void end_output() const;

 private:
  struct Piece {
    std::string own;
    std::shared_ptr<const FileBody> file;
    std::string_view rest;  ///< of either
  };
  [[nodiscard]] ssize_t send_file() const;
  [[nodiscard]] ssize_t send_memory() const;
  void sent(std::size_t bytes);
  [[nodiscard]] bool await(short events, Pace& pace) const;

  const int socket_;
  const ConnectionId id_;
  const std::string address_;
  std::string input_;
  std::size_t used_ = 0;  ///< of input_
  bool whole_ = false;
  std::deque<Piece> output_;
  std::size_t output_memory_ = 0;
};

}  // namespace parray::http
