#include <doctest/doctest.h>

#include "common/base/error.h"
#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

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

TEST_CASE("waits_for() names what a waiting job lacks") {
  FarmRig rig;
  Job& job = rig.add_job(5);
  CHECK(rig.jobs.waits_for(job) == "no workers connected");
  rig.join("peer", "one");
  CHECK(rig.jobs.waits_for(job).empty());
  rig.farm.storage = "the disk is full";
  CHECK(rig.jobs.waits_for(job) == "the disk is full");
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
