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

/// Threads that answer requests, as many as are needed up to a number. Addresses take turns. Of low
/// priority: the loop and the workers of this machine go first.
class HandlerPool {
 public:
  using Guest = std::shared_ptr<Connection>;
  /// Answers one request after the other, in a thread of its own.
  using Handler = std::function<void(const Guest&)>;

  /// `make_handler` is called once in each thread. `of_address`: most requests of one address that
  /// are answered at once.
  HandlerPool(std::size_t threads, std::size_t of_address, std::function<Handler()> make_handler)
      : most_(threads), make_handler_(std::move(make_handler)), turns_(of_address) {}
  ~HandlerPool() { stop(); }
  HandlerPool(const HandlerPool&) = delete;
  HandlerPool& operator=(const HandlerPool&) = delete;

  /// Any thread. After stop() it does nothing.
  void give(Guest guest);
  /// Waits for what is being answered; forgets the rest.
  void stop();

 private:
  void add_thread();
  void work();

  const std::size_t most_;
  const std::function<Handler()> make_handler_;
  std::mutex mutex_;  // guards all below
  std::condition_variable given_;
  Turns<Guest> turns_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool stopped_ = false;
};

}  // namespace parray::http
