#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "coordinator/http/connection_manager.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/handler_pool.h"
#include "coordinator/http/request_head.h"
#include "coordinator/http/seats.h"

namespace parray::http {

/// Limits of Server.
struct ServerLimits {
  std::size_t threads = 80;  ///< limit of threads for requests with small bodies or none
  /// Limit of further threads, for requests with large bodies. Must exceed most_uploads
  /// (upload_reader.h).
  std::size_t bodies = 40;
  SeatLimits seats{};
};

/// Speaks HTTP/1.1: a connection manager holds the connections, and threads answer requests.
/// Requests with large bodies have separate threads. Requests for /readyz, whose answer waits for
/// the coordinator's loop, have separate threads, too.
class Server {
 public:
  struct Callbacks {
    /// Returns the answer to a request. Callable from any thread.
    std::function<Reply(const Request&)> answer;
    /// As in ConnectionManager::Callbacks. `reserve`: the connection is one of
    /// SeatLimits::reserve.
    std::function<std::optional<Reply>(const RequestHead&, const std::string& address,
                                       bool reserve)>
        answer_early;
    /// As in ConnectionManager::Callbacks.
    std::function<void(const std::string&)> warn;
    /// Called with the status of each answer. Callable from any thread.
    std::function<void(int)> answered;
  };

  /// `address`: HOST:PORT; port 0 selects a free port. Throws InputError if `address` is invalid,
  /// RunError if it cannot be bound.
  Server(const std::string& address, const ServerLimits& limits, Callbacks callbacks);
  /// Cuts all connections and waits for handlers that are answering.
  ~Server();
  Server& operator=(Server&&) = delete;

  /// Starts to read requests.
  void start() { manager_.start(); }
  /// Returns the bound address as HOST:PORT.
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  HandlerPool& pool_for(const Connection& connection, const RequestHead& head);
  HandlerPool::Handler make_handler();

  const std::function<Reply(const Request&)> answer_;
  const std::function<void(int)> answered_;
  const Listener listener_;
  const std::string address_;
  ConnectionManager manager_;
  HandlerPool requests_;
  HandlerPool bodies_;
  HandlerPool readiness_;
};

}  // namespace parray::http
