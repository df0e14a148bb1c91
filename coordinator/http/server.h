#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/host_port.h"
#include "coordinator/http/connection_manager.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/seats.h"
#include "coordinator/http/turns.h"

namespace parray::http {

/// Answers requests in threads, which it starts as needed up to a limit. Addresses take turns. The
/// threads have low priority: the loop and workers of this machine run first.
class HandlerPool {
 public:
  /// Answers one request. Each thread has its own handler.
  using Handler = std::function<void(const SharedConnection&)>;

  /// `threads`: limit of threads. `make_handler` is called once in each thread. `of_address`: limit
  /// of requests of one address that are answered at the same time.
  HandlerPool(std::size_t threads, std::size_t of_address, std::function<Handler()> make_handler)
      : most_(threads), make_handler_(std::move(make_handler)), turns_(of_address) {}
  /// Waits for requests that are being answered, and drops waiting ones.
  ~HandlerPool();
  HandlerPool& operator=(HandlerPool&&) = delete;

  /// Queues a connection with a request. Callable from any thread.
  void give(SharedConnection connection);

 private:
  void work();

  const std::size_t most_;
  const std::function<Handler()> make_handler_;
  std::mutex mutex_;  // guards the fields below
  std::condition_variable given_;
  Turns<SharedConnection> turns_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool stopped_ = false;
};

/// Parses the address of Server. Throws InputError unless it is HOST:PORT.
HostPort parse_address(const std::string& address);

/// Speaks HTTP/1.1: a connection manager holds the connections, and threads answer requests.
/// Requests with large bodies have separate threads. Requests for /readyz, whose answer waits for
/// the coordinator's loop, have separate threads, too.
class Server {
 public:
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
