#pragma once

#include <functional>
#include <memory>

#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"

namespace parray::http {

/// Answers requests with cpp-httplib, one at a time. Not thread-safe.
class Conversation {
 public:
  /// `answer` returns the reply to a request. `answered` is called with the status of each answer.
  Conversation(std::function<Reply(const Request&)> answer, std::function<void(int)> answered);
  ~Conversation();
  Conversation& operator=(Conversation&&) = delete;

  /// Answers the request whose head is at the beginning of the connection's input, and puts the
  /// answer into its output. Only a stream (BodyStream) is sent here, until it ends. Throws what
  /// the stream throws. Returns false if the connection must be closed after the output is sent.
  bool answer(Connection& connection);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns the pace that both directions of every connection must keep: 32 KiB per second after 10
/// seconds of patience.
Pace default_pace();

}  // namespace parray::http
