#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "coordinator/http/connection.h"
#include "coordinator/http/turns.h"

namespace parray::http {

/// Answers requests in threads, which it starts as needed up to a limit. Addresses take turns. The
/// threads have low priority: the loop and workers of this machine run first.
class HandlerPool {
 public:
  using SharedConnection = std::shared_ptr<Connection>;
  /// Answers one request. Each thread has its own handler.
  using Handler = std::function<void(const SharedConnection&)>;

  /// `threads`: limit of threads. `make_handler` is called once in each thread. `of_address`: limit
  /// of requests of one address that are answered at the same time.
  HandlerPool(std::size_t threads, std::size_t of_address, std::function<Handler()> make_handler)
      : most_(threads), make_handler_(std::move(make_handler)), turns_(of_address) {}
  ~HandlerPool() { stop(); }
  HandlerPool& operator=(HandlerPool&&) = delete;

  /// Queues a connection with a request. Does nothing after stop(). Callable from any thread.
  void give(SharedConnection connection);
  /// Waits for requests that are being answered, and drops waiting ones.
  void stop();

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

}  // namespace parray::http
