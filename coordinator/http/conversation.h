#pragma once

#include <functional>
#include <memory>

#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"

namespace parray::http {

/// Answers requests by cpp-httplib: one connection at a time. One thread.
class Conversation {
 public:
  explicit Conversation(std::function<Reply(const Request&)> answer);
  ~Conversation();
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  /// Answers the request whose head, at least, is in the connection's input. What has to be sent is
  /// in its output then; event streams have ended. False: the connection is to be closed after
  /// that.
  bool answer(Connection& connection);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// What is demanded of all sides: 32 KiB a second after 10 seconds of patience.
Pace usual_pace();

}  // namespace parray::http
