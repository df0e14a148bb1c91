#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "coordinator/http/connection_manager.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/handler_pool.h"
#include "coordinator/http/seats.h"

namespace parray::http {

/// Speaks HTTP/1.1: a connection manager holds the connections, and threads answer requests.
/// Requests with large bodies have separate threads. Requests for /readyz, whose answer waits for
/// the coordinator's loop, have separate threads, too.
class Server {
 public:
  using Answer = std::function<Reply(const Request&)>;

  /// `address`: HOST:PORT; port 0 selects a free port. `threads`: limit of threads for requests
  /// with small bodies or none. `answer` returns the answer to a request. Any thread calls it, and
  /// `callbacks.answered`, which gets the status of each answer. Throws InputError if `address` is
  /// invalid, RunError if it cannot be bound.
  Server(const std::string& address, std::size_t threads, const SeatLimits& seats, Answer answer,
         ConnectionManager::Callbacks callbacks);
  /// Cuts all connections and waits for handlers that are answering.
  ~Server();
  Server& operator=(Server&&) = delete;

  /// Starts to read requests.
  void start() { manager_.start(); }
  /// Returns the bound address as HOST:PORT.
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  HandlerPool::Handler make_handler();

  const Answer answer_;
  const std::function<void(int)> answered_;
  const Listener listener_;
  const std::string address_;
  ConnectionManager manager_;
  HandlerPool requests_;
  HandlerPool bodies_;
  HandlerPool readiness_;
};

}  // namespace parray::http
