#include "coordinator/loop/worker_logs.h"

#include <doctest/doctest.h>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

struct LogRig : FarmRig {
  LogRig() { join("peer", "one"); }

  /// Returns the number under which the coordinator asks the worker; 0: it does not ask.
  std::uint64_t ask(const PeerId& client, std::uint64_t request, const std::string& name = "one") {
    farm.outbox.clear();
    msg::ShowLog m{request, name};
    logs.on(farm.now, client, m);
    std::uint64_t number = 0;
    for (Delivery& delivery : farm.outbox) {
      const Message message = delivery.content.open();
      if (const auto* asked = std::get_if<msg::ShowLog>(&message)) {
        CHECK(delivery.peer == "peer");
        number = asked->request;
      }
    }
    return number;
  }
  void answer(const PeerId& worker, std::uint64_t number) {
    msg::Log m{number, {"serving"}};
    logs.on(farm.now, worker, m);
  }

  WorkerLogs logs{farm};
};

TEST_CASE("a client gets the lines that the worker sends") {
  LogRig rig;
  const std::uint64_t number = rig.ask("client", 77);
  REQUIRE(number != 0);
  rig.farm.outbox.clear();
  rig.answer("peer", number);
  REQUIRE(rig.farm.outbox.size() == 1);
  CHECK(rig.farm.outbox[0].peer == "client");
  const auto answers = rig.sent<msg::Log>();
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].request == 77);
  CHECK(answers[0].lines == std::vector<std::string>{"serving"});
  rig.answer("peer", number);  // once more
  CHECK(rig.sent<msg::Log>().empty());
}

TEST_CASE("another worker cannot answer, nor one that nobody asked") {
  LogRig rig;
  rig.join("other", "two");
  const std::uint64_t number = rig.ask("client", 1);
  rig.farm.outbox.clear();
  rig.answer("other", number);
  rig.answer("peer", number + 1);
  CHECK(rig.sent<msg::Log>().empty());
}

TEST_CASE("a worker that does not answer costs its client 3 s and an error with a remedy") {
  LogRig rig;
  rig.ask("client", 5);
  rig.farm.outbox.clear();
  CHECK(rig.logs.expire(rig.farm.now + milliseconds(2999)) == rig.farm.now + seconds(3));
  CHECK(rig.farm.outbox.empty());
  CHECK(rig.logs.expire(rig.farm.now + seconds(3)) == never);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].request == 5);
  CHECK(errors[0].status == 1);
  CHECK(errors[0].message.find("'one'") != std::string::npos);
  CHECK(errors[0].message.find("read its output") != std::string::npos);
}

TEST_CASE("a repeated request asks the worker once") {
  LogRig rig;
  CHECK(rig.ask("client", 5) != 0);
  CHECK(rig.ask("client", 5) == 0);
  CHECK(rig.sent<msg::Error>().empty());
  CHECK(rig.ask("client", 6) != 0);
}

TEST_CASE("a request about an unknown worker says what became of it") {
  LogRig rig;
  CHECK(rig.ask("client", 5, "nobody") == 0);
  CHECK(rig.sent<msg::Error>()[0].message.find("no worker 'nobody'") != std::string::npos);
  rig.workers.lose_worker(rig.farm.now, "peer", "silent for too long", true);
  CHECK(rig.ask("client", 6) == 0);
  CHECK(rig.sent<msg::Error>()[0].message.find("was lost 0 s ago (silent for too long)") !=
        std::string::npos);
}

TEST_CASE("only a few requests wait for workers; a further client may try again later") {
  LogRig rig;
  for (std::uint64_t i = 0; i < WorkerLogs::most_waiting; ++i) CHECK(rig.ask("client", i) != 0);
  CHECK(rig.ask("client", 1000) == 0);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].later);
}

}  // namespace
}  // namespace parray
