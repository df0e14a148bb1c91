// A client requests a change and gets an answer. Then the change survives a killed coordinator.
#include <doctest/doctest.h>

#include <string>

#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// Sends a request, repeats it until its answer comes, and kills the coordinator at that moment.
template <typename Answer>
void ask_and_kill(Service& service, CrashStore& store, const Message& request) {
  constexpr int most_turns = 200;
  for (int i = 0; i < most_turns; ++i) {
    service.say("client", request);
    service.turn();
    if (!service.heard<Answer>("client").empty()) {
      store.crash();
      service.restart();
      return;
    }
  }
  FAIL("no answer");
}

bool has_job(Service& service, JobId id) { return !service.job(id).is_null(); }

}  // namespace

TEST_CASE("a change of a job outlives a coordinator that is killed right after its answer") {
  using enum msg::JobAction;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    CrashStore store(0.5, seed);  // half of its commits fail
    Service service(service_options(), &store);
    Hand hand(service, "a");
    msg::Submit submit = service.submission(small_scene(), many_leases());
    ask_and_kill<msg::Submitted>(service, store, submit);
    constexpr JobId id = 1;
    REQUIRE(has_job(service, id));
    std::uint64_t request = 0;
    const auto steer = [&](msg::JobAction action, std::uint32_t priority = 50) {
      ask_and_kill<msg::Job>(service, store, msg::SteerJob{++request, id, action, priority});
    };
    steer(prioritise, 7);
    CHECK(service.job(id).at("priority") == 7);
    steer(pause);
    CHECK(service.state(id) == "paused");
    hand.join();
    work(service, {{&hand, honest}}, id, 3);
    steer(cancel);
    CHECK(service.state(id) == "cancelled");
    steer(requeue);
    CHECK(service.state(id) == "queued");
    ask_and_kill<msg::Steered>(service, store, msg::SteerJobs{++request, {id}, cancel, 50});
    CHECK(service.state(id) == "cancelled");
    steer(forget);
    CHECK_FALSE(has_job(service, id));
  }
}

TEST_CASE("a drain of a worker outlives a coordinator that is killed right after its answer") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CAPTURE(seed);
    CrashStore store(0.5, seed);
    Service service(service_options(), &store);
    ask_and_kill<msg::Workers>(service, store,
                               msg::SteerWorkers{1, msg::WorkerAction::drain, false, "a"});
    Hand hand(service, "a");
    CHECK(service.worker("a").at("state") == "drained");
  }
}

TEST_CASE("a change that cannot be stored is not confirmed, and a repeated request says why") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  const JobId id = service.submit(small_scene(), many_leases());
  store.fill(true);
  const msg::SteerJob cancel{1, id, msg::JobAction::cancel, 50};
  service.say("client", cancel);
  service.turn();
  CHECK(service.heard<msg::Job>("client").empty());
  CHECK(service.heard<msg::Error>("client").empty());
  service.say("client", cancel);
  service.turn();
  const auto errors = service.heard<msg::Error>("client");
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].status == 1);
  CHECK(errors[0].message.find("not stored yet") != std::string::npos);
  CHECK(errors[0].message.find("disk full") != std::string::npos);
  store.fill(false);
  service.turn(seconds(1));
  const auto answers = service.heard<msg::Job>("client");
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].job.at("state") == "cancelled");
}

}  // namespace parray::test
