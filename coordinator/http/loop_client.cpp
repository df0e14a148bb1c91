#include "coordinator/http/loop_client.h"

#include "common/base/printable.h"

namespace parray::http {

void LoopClient::fail(const msg::Error& error) {
  const int status = error.later ? 503 : error.status == 2 ? 409 : 500;
  throw Problem(status, printable(error.message, 2000), static_cast<int>(error.status));
}

void LoopClient::fail_unanswered() const {
  throw Problem(503, stopped_ ? "the coordinator is stopping: try again later"
                              : "the coordinator does not answer: try again later");
}

}  // namespace parray::http
