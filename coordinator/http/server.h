#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "coordinator/http/exchange.h"

namespace parray::http {

/// Speaks HTTP/1.1 by cpp-httplib, with a bounded number of threads. What is asked goes to
/// `answer`, from any of them.
class Server {
 public:
  /// `address`: HOST:PORT, port 0 for a free one. `threads`: as many connections are served at
  /// once; others wait. Throws InputError when `address` is none, RunError when it cannot be bound.
  Server(const std::string& address, std::size_t threads,
         std::function<Reply(const Request&)> answer);
  /// Waits for what is being answered.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// From now on requests are heard.
  void start();
  /// HOST:PORT as bound.
  [[nodiscard]] const std::string& address() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parray::http
