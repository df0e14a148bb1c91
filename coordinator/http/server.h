#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "coordinator/http/exchange.h"
#include "coordinator/http/request_head.h"
#include "coordinator/http/seats.h"

namespace parray::http {

struct ServerLimits {
  std::size_t threads = 80;  ///< requests that are answered at once
  std::size_t bodies = 40;   ///< with a body that does not come at once; more than `most_uploads`
  SeatLimits seats{};
};

/// Speaks HTTP/1.1: a doorman holds the connections, threads answer requests. Requests with large
/// bodies and those for /readyz, which waits for the loop, have threads of their own.
class Server {
 public:
  struct Callbacks {
    /// The answer to a request. Any thread.
    std::function<Reply(const Request&)> answer;
    /// As Doorman::Callbacks.
    std::function<std::optional<Reply>(const RequestHead&, const std::string& address,
                                       bool reserve)>
        at_door;
    std::function<void(const std::string&)> warn;
  };

  /// `address`: HOST:PORT, port 0 for a free one. Throws InputError when `address` is none,
  /// RunError when it cannot be bound.
  Server(const std::string& address, const ServerLimits& limits, Callbacks callbacks);
  /// Cuts all connections, and waits for what is being answered.
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
