// A list of addresses over real sockets.
#include <doctest/doctest.h>

#include "common/base/error.h"
#include "tests/support/rooms.h"
#include "tests/support/served.h"

namespace parray::test {

TEST_CASE("a client with two addresses finds the coordinator at the second and stays there") {
  // Accepts connections but never answers, like a stopped process.
  const ZmqServer silent("tcp://127.0.0.1:*", default_max_message_bytes);
  const std::string first = silent.endpoint();
  const Server second(CoordinatorOptions{});
  const auto link =
      zmq_connect(first + "," + second.endpoint(), default_max_message_bytes, seconds(1));
  const SteadyClock clock;
  std::uint64_t request = 0;
  // Asks as clients do, until there is an answer.
  const auto seconds_to_answer = [&] {
    const Time began = clock.now();
    ++request;
    for (Time now = began; now < began + seconds(30); now = clock.now()) {
      link->send({}, Message(msg::ListJobs{request}));
      link->wait(milliseconds(100));
      while (auto delivery = link->receive()) {
        const Message message = delivery->content.open();
        const auto* jobs = std::get_if<msg::Jobs>(&message);
        if (jobs != nullptr && jobs->request == request) return to_seconds(clock.now() - began);
      }
    }
    return 30.0;
  };
  const double found = seconds_to_answer();
  CHECK(found >= 5);
  CHECK(found < 10);
  CHECK(seconds_to_answer() < 5);  // so long it would try the first again
}

TEST_CASE("a list with a bad address is refused at once, whichever it is") {
  const std::string good = "tcp://127.0.0.1:7400";
  for (const std::string& list : {good + ",nonsense", "nonsense," + good, good + ","}) {
    CHECK_THROWS_AS(zmq_connect(list, default_max_message_bytes, Time(0)), InputError);
  }
}

}  // namespace parray::test
