#pragma once

#include <functional>

#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"

namespace parray::http {

/// Returns a function that answers requests with cpp-httplib, one at a time. It is not thread-safe.
/// `answer` returns the reply to a request. `answered` is called with the status of each answer.
///
/// The function answers the request whose head is at the beginning of the connection's input, and
/// puts the answer into its output. Only a stream (BodyStream) is sent there, until it ends. The
/// function throws what the stream throws. It returns false if the connection must be closed after
/// the output is sent.
std::function<bool(Connection&)> make_conversation(Answer answer,
                                                   std::function<void(int)> answered);

}  // namespace parray::http
