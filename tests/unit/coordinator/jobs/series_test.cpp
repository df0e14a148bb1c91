#include "coordinator/jobs/series.h"

#include <doctest/doctest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

/// A series, number 10, of two frames: jobs 11 and 12.
struct SeriesRig : FarmRig {
  explicit SeriesRig(CoordinatorOptions options = rig_options()) : FarmRig(std::move(options)) {
    frame(11, 0);
    frame(12, 1);
  }
  Job& frame(JobId id, std::uint32_t number) {
    Job job;
    job.record.id = id;
    job.record.series = "dance";
    job.record.series_id = 10;
    job.record.frame = number;
    job.record.frames = 2;
    job.record.note(100 + number, "submitted by ann");
    job.record.settings->width = job.record.settings->height = 8;
    Job& added = farm.jobs.emplace(id, std::move(job)).first->second;
    farm.index.add(added);
    return added;
  }
  Series series() { return series_of(*farm.index.listed_as(10)); }
  std::vector<std::string> history() {
    std::vector<std::string> lines;
    for (const JobEvent& event : events_of(series())) lines.push_back(event.what);
    return lines;
  }
};

}  // namespace

TEST_CASE("the priority of a series is that of its unfinished frames") {
  SeriesRig rig;
  rig.jobs.fail_job(rig.farm.jobs.at(11), "in a test");
  rig.jobs.steer(rig.farm.jobs.at(12), {1, 12, msg::JobAction::prioritise, 90});
  CHECK(rig.jobs.summary_of(rig.farm.now, rig.series()).at("priority") == 90);
}

TEST_CASE("a frame is not forgotten before its series has ended") {
  SeriesRig rig;
  Job& first = rig.farm.jobs.at(11);
  rig.jobs.fail_job(first, "in a test");
  CHECK_THROWS_WITH_AS(rig.jobs.steer(first, {1, 11, msg::JobAction::forget, 0}),
                       doctest::Contains("is a frame of series 10, which has not ended"),
                       InputError);
  rig.jobs.fail_job(rig.farm.jobs.at(12), "in a test");
  CHECK_NOTHROW(rig.jobs.steer(first, {1, 11, msg::JobAction::forget, 0}));
}

TEST_CASE("an old frame stays as long as another frame of its series is unfinished") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.limits.keep_seconds = 100;
  SeriesRig rig(options);
  rig.jobs.fail_job(rig.farm.jobs.at(11), "in a test");
  rig.farm.now = seconds(1000);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(rig.farm.job_of(11) != nullptr);
}

TEST_CASE("the frames of an ended series are forgotten together, by the age of the latest") {
  CoordinatorOptions options = FarmRig::rig_options();
  options.limits.keep_seconds = 100;
  SeriesRig rig(options);
  rig.jobs.fail_job(rig.farm.jobs.at(11), "in a test");
  rig.farm.now = seconds(1000);
  rig.jobs.fail_job(rig.farm.jobs.at(12), "in a test");
  rig.jobs.keep_house(rig.farm.now);
  CHECK(rig.farm.job_of(11) != nullptr);
  rig.farm.now = seconds(2000);
  rig.jobs.keep_house(rig.farm.now);
  CHECK(rig.farm.job_of(11) == nullptr);
  CHECK(rig.farm.job_of(12) == nullptr);
}

TEST_CASE("the list of frames states what each took and its error") {
  SeriesRig rig;
  Job& first = rig.farm.jobs.at(11);
  first.record.course.started = 110;
  first.record.course.finished = 150;
  first.record.course.taken = 40;
  first.record.state = JobState::done;
  first.stored = true;
  first.record.course.error.rmse = 0.25;
  const nlohmann::json list = frame_list(rig.series(), rig.farm.now, 0);
  REQUIRE(list.size() == 2);
  CHECK(list[0].at("seconds") == 40);
  CHECK(list[0].at("rmse") == 0.25);
  CHECK(list[0].at("progress") == 1);
  CHECK(list[0].at("has_picture") == true);
  CHECK(list[1].at("seconds").is_null());
  CHECK(list[1].at("rmse").is_null());
  CHECK(list[1].at("has_picture") == false);
}

TEST_CASE("a series has no error of its first frame, neither a final nor a partial one") {
  SeriesRig rig;
  Job& first = rig.farm.jobs.at(11);
  first.work = std::make_unique<JobWork>();
  first.work->error_so_far.share = 0.5;
  CHECK(job_summary(first, rig.farm.now, "").contains("error_so_far"));
  CHECK_FALSE(series_summary(rig.series(), rig.farm.now, "").contains("error_so_far"));
  first.record.course.error.rmse = 0.25;
  CHECK(job_summary(first, rig.farm.now, "").contains("error"));
  CHECK_FALSE(series_summary(rig.series(), rig.farm.now, "").contains("error"));
}

TEST_CASE("a frame that was queued again has no end, and the time of its series goes on") {
  SeriesRig rig;
  JobCourse& first = rig.farm.jobs.at(11).record.course;
  first.started = 110;
  first.finished = 150;  // before it was queued again
  first.taken = 70;
  CHECK(frame_list(rig.series(), rig.farm.now, 0)[0].at("seconds") == 70);
  CHECK(rig.jobs.summary_of(rig.farm.now, rig.farm.jobs.at(11)).at("finished").is_null());
  const nlohmann::json all = rig.jobs.summary_of(rig.farm.now, rig.series());
  CHECK(all.at("started") == 110);
  CHECK(all.at("finished").is_null());
  CHECK(all.at("seconds_taken") == 70);
}

TEST_CASE("failed and cancelled frames keep their progress in that of their series") {
  SeriesRig rig;
  for (const JobId id : {JobId{11}, JobId{12}}) {
    Job& frame = rig.farm.jobs.at(id);
    frame.record.course.progress = id == 11 ? 0.5 : 0;
    rig.jobs.steer(frame, {1, id, msg::JobAction::cancel, 0});
  }
  CHECK(rig.jobs.summary_of(rig.farm.now, rig.series()).at("progress") == 0.25);
}

TEST_CASE("the history of a series merges what happened to all frames and names single ones") {
  SeriesRig rig;
  Job& first = rig.farm.jobs.at(11);
  Job& second = rig.farm.jobs.at(12);
  for (Job* job : {&first, &second}) {
    job->record.note(110, "started");
    job->record.note(120, "paused by ann");
  }
  first.record.note(130, "done");
  second.record.note(140, "failed: out of memory");
  CHECK(rig.history() == std::vector<std::string>{"submitted by ann", "started", "paused by ann",
                                                  "frame 1: failed: out of memory"});
}

TEST_CASE("the history of a series is bounded") {
  SeriesRig rig;
  for (Job* job : {&rig.farm.jobs.at(11), &rig.farm.jobs.at(12)}) {
    for (int i = 0; i < 60; ++i) job->record.note(200 + 10 * i, "event " + std::to_string(i));
    for (int i = 0; i < 60; ++i) job->record.note(900 + 10 * i, "later " + std::to_string(i));
  }
  CHECK(rig.history().size() <= 64);
}

}  // namespace parray::test
