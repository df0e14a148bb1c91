#include "coordinator/http/upload_reader.h"

#include <doctest/doctest.h>

#include <csignal>
#include <string>

#include "tests/support/rooms.h"

namespace parray::http {

TEST_CASE("the message about a limit of time names the limit that the child reached") {
  ChildLimits limits;
  limits.seconds = 70;
  ChildEnd end;
  end.timed_out = true;
  end.signal = SIGXCPU;
  CHECK(time_limit_message(end, limits)
            .starts_with("reading the scene took more than 70 seconds of processor time, the limit "
                         "of this server: "));
  end.signal = SIGKILL;
  CHECK(
      time_limit_message(end, limits)
          .starts_with("reading the scene took more than 140 seconds, the limit of this server: "));
}

}  // namespace parray::http
