#include <doctest/doctest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/error.h"
#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using test::FarmRig;

TEST_CASE("a job beyond the limit per user is refused") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.limits.user_jobs = 2;
  FarmRig rig(options);
  rig.add_job(1, "ann");
  JobRecord next;
  next.id = 3;
  next.user = "ann";
  CHECK_NOTHROW(rig.jobs.check_limits(next));
  rig.add_job(2, "ann");
  CHECK_THROWS_AS(rig.jobs.check_limits(next), NoRoom);
  next.user = "bob";
  CHECK_NOTHROW(rig.jobs.check_limits(next));
}

TEST_CASE("a cancelled job can be queued again; only an ended job can be forgotten") {
  FarmRig rig;
  Job& job = rig.add_job(5);
  job.scene = ScenePayload(std::make_shared<const Scene>());
  CHECK_THROWS_AS(rig.jobs.steer(job, {1, 5, msg::JobAction::forget, 0}), InputError);
  rig.jobs.steer(job, {1, 5, msg::JobAction::cancel, 0});
  CHECK(job.record.state == JobState::cancelled);
  CHECK(rig.farm.index.open().empty());
  rig.jobs.forget_job(5, "in a test");
  CHECK(rig.farm.job_of(5) == nullptr);
}

TEST_CASE("two users who submit the same token at once get a job each") {
  FarmRig rig;
  for (const std::string user : {"ann", "bob", "ann"}) {
    rig.farm.sender = {Role::client, user};
    msg::Submit submit;
    submit.request = 1;
    submit.token = "token";
    submit.name = "scene";
    submit.settings = test::small_settings(test::small_scene());
    submit.scene = ScenePayload(std::make_shared<const Scene>(test::small_scene()));
    rig.jobs.on(rig.farm.now, "client of " + user, submit);
  }
  rig.job_thread.run_finished();
  CHECK(rig.sent<msg::Submitted>().size() == 2);  // a repeated submit has one answer
  CHECK(rig.farm.jobs.size() == 2);
}

TEST_CASE("without a store, pictures of cancelled jobs are dropped before those of done jobs") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.memory = 1000;
  FarmRig rig(options);
  Job& done = rig.add_job(1);
  rig.jobs.fail_job(done, "in a test");
  done.record.state = JobState::done;
  done.picture_bytes = 400;
  Job& cancelled = rig.add_job(2);
  rig.jobs.steer(cancelled, {1, 2, msg::JobAction::cancel, 0});
  cancelled.picture_bytes = 400;
  CHECK(rig.jobs.make_room(100));
  CHECK(cancelled.has_picture());
  CHECK(rig.jobs.make_room(400));
  CHECK_FALSE(cancelled.has_picture());
  CHECK(done.has_picture());
}

TEST_CASE("the priority of an ended job cannot be changed") {
  FarmRig rig;
  Job& job = rig.add_job(5);
  rig.jobs.steer(job, {1, 5, msg::JobAction::prioritise, 90});
  CHECK(job.record.priority == 90);
  rig.jobs.fail_job(job, "in a test");
  CHECK(job.record.state == JobState::failed);
  CHECK_THROWS_AS(rig.jobs.steer(job, {1, 5, msg::JobAction::prioritise, 10}), InputError);
}

TEST_CASE("wait_of() names what a waiting job lacks, as a noun") {
  FarmRig rig;
  Job& job = rig.add_job(5);
  CHECK(rig.jobs.wait_of(job).what == "a worker (none is connected)");
  rig.join("peer", "one");
  rig.farm.now += seconds(1);
  CHECK(rig.jobs.wait_of(job).what.empty());
  CHECK(rig.jobs.wait_of(job).place == 1);
  rig.farm.storage = "the disk is full";
  CHECK(rig.jobs.wait_of(job).what == "storage (the disk is full)");
}

TEST_CASE("a waiting job names the job of higher priority that goes first") {
  FarmRig rig;
  rig.join("peer", "one");
  rig.add_job(5, "ann").record.priority = 50;
  Job& behind = rig.add_job(6, "ann");
  behind.record.priority = 10;
  const JobBook::Wait wait = rig.jobs.wait_of(behind);
  CHECK(wait.what == "job 5 of priority 50");
  CHECK(wait.job == 5);
  CHECK(wait.place == 2);
  CHECK_FALSE(wait.starts_in);  // no result has shown the speed of the farm
  behind.record.state = JobState::paused;
  CHECK(rig.jobs.wait_of(behind).what.empty());
  CHECK(rig.jobs.wait_of(behind).place == 0);
}

TEST_CASE("the queue of a list is made once a second, and soon after a change") {
  FarmRig rig;
  rig.join("peer", "one");
  rig.add_job(5, "ann");
  CHECK(rig.jobs.wait_of(rig.farm.jobs.at(5)).place == 1);
  Job& later = rig.add_job(6, "ann");
  CHECK(rig.jobs.wait_of(later).place == 0);
  rig.jobs.list_open_jobs();
  rig.farm.now += milliseconds(100);
  CHECK(rig.jobs.wait_of(later).place == 2);
}

TEST_CASE("a job that will take more than a day gets one warning") {
  FarmRig rig;
  rig.join("peer", "one");
  Job& job = rig.add_job(5);
  job.phase = JobPhase::tracing;
  job.work = std::make_unique<JobWork>();
  job.work->started = rig.farm.now;
  job.work->price = 1e6;  // thread-seconds per sample
  rig.farm.at_work.insert(5);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(job.record.warning.empty());  // too early to know
  rig.farm.now += seconds(120);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(job.record.warning.find("days of all 2 present threads") != std::string::npos);
  const std::size_t events = job.record.events.size();
  CHECK(events == 1);
  rig.farm.now += seconds(120);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(job.record.events.size() == events);
  CHECK(rig.jobs.summary_of(rig.farm.now, job).at("warning") == job.record.warning);
}

TEST_CASE("a quick look is forgotten with its job, even if it is unfinished") {
  FarmRig rig;
  Job& job = rig.add_job(5, "ann");
  Job preview;
  preview.record.id = 6;
  preview.record.user = "ann";
  preview.record.preview_of = 5;
  rig.farm.index.add(rig.farm.jobs.emplace(6, std::move(preview)).first->second);
  CHECK(rig.jobs.summary_of(rig.farm.now, rig.farm.jobs.at(6)).at("preview_of") == 5);
  rig.jobs.fail_job(job, "in a test");
  rig.jobs.forget_job(5, "in a test");
  CHECK(rig.farm.jobs.empty());
  CHECK(rig.farm.index.open().empty());
}

TEST_CASE("jobs that ended long ago are forgotten, open ones are not") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.limits.keep_seconds = 100;
  FarmRig rig(options);
  rig.add_job(1);
  rig.jobs.steer(rig.add_job(2), {1, 2, msg::JobAction::cancel, 0});
  rig.farm.now = seconds(50);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(rig.farm.jobs.size() == 2);
  rig.farm.now = seconds(200);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(rig.farm.job_of(1) != nullptr);
  CHECK(rig.farm.job_of(2) == nullptr);
}

}  // namespace
}  // namespace parray
