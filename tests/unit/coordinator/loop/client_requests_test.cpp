#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("a request about an unknown job is answered with status 2") {
  FarmRig rig;
  msg::ShowJob m{1, 5};
  rig.clients.on(rig.farm.now, "client", m);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].status == 2);
  CHECK(errors[0].message.find("no job 5") != std::string::npos);
}

TEST_CASE("only an administrator may change the job of another user") {
  FarmRig rig;
  Job& job = rig.add_job(5, "ann");
  rig.farm.sender = {Role::client, "bob"};
  msg::SteerJob pause{1, 5, msg::JobAction::pause, 50};
  rig.clients.on(rig.farm.now, "client", pause);
  CHECK(rig.sent<msg::Error>().size() == 1);
  CHECK(job.record.state == JobState::queued);

  rig.farm.sender = {Role::admin, "carol"};
  rig.clients.on(rig.farm.now, "client", pause);
  CHECK(rig.sent<msg::Job>().size() == 1);
  CHECK(job.record.state == JobState::paused);
}

TEST_CASE("many jobs are changed at once, with the checks of a single one") {
  FarmRig rig;
  rig.add_job(5, "bob");
  rig.add_job(6, "ann");
  rig.jobs.fail_job(rig.add_job(7, "bob"), "in a test");
  rig.farm.sender = {Role::client, "bob"};
  msg::SteerJobs cancel{3, {5, 6, 7, 8}, msg::JobAction::cancel, 50};
  rig.clients.on(rig.farm.now, "client", cancel);
  const auto answers = rig.sent<msg::Steered>();
  REQUIRE(answers.size() == 1);
  const nlohmann::json& results = answers[0].results;
  REQUIRE(results.size() == 4);
  CHECK(results[0].at("job").at("state") == "cancelled");
  CHECK(results[1].at("refusal") == "forbidden");
  CHECK(results[2].at("refusal") == "state");
  CHECK(results[3].at("refusal") == "missing");
  CHECK(rig.farm.jobs.at(6).record.state == JobState::queued);
}

TEST_CASE("an action that does not fit a job is refused, but not if the request is repeated") {
  FarmRig rig;
  rig.add_job(5);
  const auto steer = [&](std::uint64_t request, msg::JobAction action) {
    msg::SteerJob m{request, 5, action, 50};
    rig.clients.on(rig.farm.now, "client", m);
    return rig.sent<msg::Job>().size();
  };
  CHECK(steer(1, msg::JobAction::resume) == 0);
  CHECK(steer(2, msg::JobAction::pause) == 1);
  CHECK(steer(3, msg::JobAction::pause) == 1);  // as it was asked
  CHECK(steer(4, msg::JobAction::resume) == 1);
  CHECK(steer(4, msg::JobAction::resume) == 1);  // the first answer may be lost
  CHECK(steer(5, msg::JobAction::resume) == 0);
  CHECK(steer(6, msg::JobAction::cancel) == 1);
  CHECK(steer(6, msg::JobAction::cancel) == 1);
  CHECK(steer(7, msg::JobAction::cancel) == 0);
  CHECK(steer(8, msg::JobAction::pause) == 0);
}

TEST_CASE("a repeated request for a picture from a log waits for the first one's answer") {
  FarmRig rig;
  Job& job = rig.add_job(5);
  job.record.course.samples = 1000;
  rig.jobs.fail_job(job, "in a test");
  job.stored = true;
  const auto reading = rig.farm.log_pictures.admit("client", 1);  // the job thread is busy with it
  msg::Fetch fetch{1, 5, true};
  rig.clients.on(rig.farm.now, "client", fetch);
  CHECK(rig.sent<msg::Error>().empty());
  rig.clients.on(rig.farm.now, "another client", fetch);
  const auto refused = rig.sent<msg::Error>();
  REQUIRE(refused.size() == 1);
  CHECK(refused[0].later);
}

TEST_CASE("a repeated request for a picture, journal or scene waits for the first one's answer") {
  FarmRig rig;
  rig.add_job(5);
  std::vector<BulkLedger::Ticket> answers;  // the client has as many as are permitted
  while (auto ticket = rig.farm.bulk.admit("client", 1, 7)) answers.push_back(std::move(ticket));
  const auto errors_after = [&](std::uint64_t request) {
    msg::Fetch fetch{request, 5, false};
    msg::FetchJournal journal{request, 5};
    msg::FetchScene scene{request, 5};
    rig.clients.on(rig.farm.now, "client", fetch);
    rig.clients.on(rig.farm.now, "client", journal);
    rig.clients.on(rig.farm.now, "client", scene);
    return rig.sent<msg::Error>().size();
  };
  CHECK(errors_after(7) == 0);
  CHECK(errors_after(8) == 3);
}

TEST_CASE("a client may not drain workers") {
  FarmRig rig;
  WorkerRecord& worker = rig.join("peer", "one");
  rig.farm.sender = {Role::client, "bob"};
  msg::SteerWorkers drain{1, msg::WorkerAction::drain, false, "one"};
  rig.clients.on(rig.farm.now, "client", drain);
  CHECK(rig.sent<msg::Error>().size() == 1);
  CHECK(worker.may_trace());

  rig.farm.sender = {Role::admin, "carol"};
  rig.clients.on(rig.farm.now, "client", drain);
  CHECK_FALSE(worker.may_trace());
}

TEST_CASE("a fetch of an unfinished picture is refused") {
  FarmRig rig;
  rig.add_job(5);
  msg::Fetch m{1, 5, false, false};
  rig.clients.on(rig.farm.now, "client", m);
  const auto errors = rig.sent<msg::Error>();
  REQUIRE(errors.size() == 1);
  CHECK(errors[0].message.find("queued, not done") != std::string::npos);
}

}  // namespace
}  // namespace parray
