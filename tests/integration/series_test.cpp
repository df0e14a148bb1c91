// Frames that were submitted as one job: how the coordinator shows, steers, limits and keeps them.
#include <doctest/doctest.h>

#include <set>
#include <string>

#include "tests/support/contains.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

using nlohmann::json;

msg::Submit frame_of(Service& service, std::uint32_t frame, std::uint32_t frames,
                     const std::string& series = "dance") {
  msg::Submit submit = service.submission(small_scene(), many_leases());
  submit.token = series + std::to_string(frame);
  submit.series = series;
  submit.frame = frame;
  submit.frames = frames;
  return submit;
}

/// Submits the frames of a series from `first` on, and returns the series' number.
JobId submit_series(Service& service, std::uint32_t frames, std::uint32_t first = 0) {
  JobId job = 0;
  for (std::uint32_t frame = first; frame < frames; ++frame) {
    job = service.ask<msg::Submitted>(frame_of(service, frame, frames)).job;
  }
  return service.job(job).at("series");
}

JobId job_of(Service& service, JobId series, std::size_t place) {
  return service.job(series).at("frame_list").at(place).at("job");
}

json listed(Service& service) { return service.ask<msg::Jobs>(msg::ListJobs{1}).jobs; }

/// Gives every worker without a lease a lease, and returns their results.
void round(Service& service, const Hands& hands) {
  service.turn();
  for (const auto& [hand, manner] : hands) {
    hand->listen();
    hand->beat();
    if (!hand->held.empty()) manner(*hand, hand->put_down());
  }
  service.turn(Time(0));
}

}  // namespace

TEST_CASE(
    "a series is listed as one job with its frames' progress, each frame is a job of its own") {
  Service service;
  const JobId series = submit_series(service, 3);
  json list = listed(service);
  REQUIRE(list.size() == 1);
  CHECK(list[0].at("id") == series);
  CHECK(list[0].at("state") == "queued");
  CHECK(list[0].at("frames") == 3);
  CHECK(list[0].at("frames_done") == 0);
  Hand hand(service, "w");
  work(service, {{&hand, honest}}, job_of(service, series, 0));
  list = listed(service);
  CHECK(list[0].at("state") == "running");
  CHECK(list[0].at("frames_done") == 1);
  CHECK(list[0].at("progress") >= doctest::Approx(1.0 / 3));
  work(service, {{&hand, honest}}, series);
  const json map = service.job(series);
  CHECK(map.at("state") == "done");
  CHECK(map.at("progress") == 1);
  CHECK(map.at("frame_list").size() == 3);
  for (std::size_t place = 0; place < 3; ++place) {
    const JobId job = job_of(service, series, place);
    CHECK(service.job(job).at("frame") == place);
    CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  }
  CHECK(contains(service.refusal(msg::Fetch{1, series, false, false}), "is a series of frames"));
  CHECK(service.ask<msg::Job>(msg::ShowJob{1, series, 2}).job.at("frame_list").size() == 1);
}

TEST_CASE("a series with frames that have not been submitted is not done, and says so") {
  Service service;
  Hand hand(service, "w");
  const JobId first = service.ask<msg::Submitted>(frame_of(service, 0, 2)).job;
  work(service, {{&hand, honest}}, first);
  const JobId series = service.job(first).at("series");
  CHECK(service.state(series) == "queued");
  CHECK(contains(service.job(series).at("waits_for"), "1 of 2 frames"));
  CHECK(service.job(series).at("progress") == 0.5);
  CHECK(submit_series(service, 2, 1) == series);
  work(service, {{&hand, honest}}, series);
  CHECK(service.state(series) == "done");
}

TEST_CASE("a failed frame does not affect the others, and the series' reason names it") {
  CoordinatorOptions options = service_options();
  options.max_failures = 1;
  Service service(options);
  Hand hand(service, "w");
  const JobId series = submit_series(service, 3);
  const JobId bad = job_of(service, series, 1);
  work(service,
       {{&hand,
         [&](Hand& w, const msg::Grant& grant) {
           grant.job == bad ? w.send_failure(grant) : w.send_honest(grant);
         }}},
       series);
  CHECK(service.state(series) == "failed");
  CHECK(contains(service.job(series).at("reason"), "1 of 3 frames failed: first frame 1: "));
  CHECK(service.job(series).at("frames_done") == 2);
  CHECK(service.state(job_of(service, series, 2)) == "done");
  CHECK(service.steer(series, msg::JobAction::requeue).at("state") == "running");
  work(service, {{&hand, honest}}, series);
  CHECK(service.state(series) == "done");
}

TEST_CASE("an action on a series applies to all its frames, also to later ones") {
  Service service;
  const JobId first = service.ask<msg::Submitted>(frame_of(service, 0, 3)).job;
  const JobId series = service.job(first).at("series");
  CHECK(service.steer(series, msg::JobAction::prioritise, 70).at("priority") == 70);
  CHECK(service.steer(series, msg::JobAction::pause).at("state") == "paused");
  CHECK(contains(service.job(series).at("reason"), "parray resume " + std::to_string(series)));
  submit_series(service, 3, 1);
  CHECK(service.state(series) == "paused");
  CHECK(service.job(job_of(service, series, 2)).at("priority") == 70);
  Hand hand(service, "w");
  round(service, {{&hand, honest}});
  CHECK(service.tally().granted == 0);
  CHECK(service.steer(series, msg::JobAction::resume).at("state") == "queued");
  round(service, {{&hand, honest}});
  round(service, {{&hand, honest}});
  CHECK(service.tally().granted > 0);
  CHECK(contains(service.refusal(msg::SteerJob{1, series, msg::JobAction::forget, 0}),
                 "has not ended"));
  service.steer(first, msg::JobAction::cancel);
  CHECK(service.state(series) != "cancelled");
  CHECK(service.steer(series, msg::JobAction::cancel).at("state") == "cancelled");
  CHECK(contains(service.refusal(frame_of(service, 3, 4)), "was cancelled"));
  service.steer(series, msg::JobAction::forget);
  CHECK(listed(service).empty());
}

TEST_CASE("limits count a series as one job, and its pixels a frame at a time") {
  CoordinatorOptions options = service_options();
  options.limits.jobs = 2;
  options.limits.user_jobs = 2;
  const std::size_t pixels = std::size_t{many_leases().width} * many_leases().height;
  options.limits.user_pixels = 2 * pixels;
  Service service(options);
  const JobId series = submit_series(service, 5);
  CHECK(series > 0);
  service.submit(small_scene(), many_leases());
  const auto refused = service.ask<msg::Error>(service.submission(small_scene(), many_leases()));
  CHECK(contains(refused.message, "--max-user-jobs"));
  CHECK(refused.later);
  CHECK(service.ask<msg::Submitted>(frame_of(service, 5, 6)).job > 0);
  CHECK(listed(service).size() == 2);
}

TEST_CASE("the oldest ended series makes room as a whole; one with missing frames does not") {
  CoordinatorOptions options = service_options();
  options.limits.jobs = 2;
  Service service(options);
  Hand hand(service, "w");
  const JobId incomplete = service.ask<msg::Submitted>(frame_of(service, 0, 2, "long")).job;
  work(service, {{&hand, honest}}, incomplete);
  const JobId series = submit_series(service, 2);
  work(service, {{&hand, honest}}, series);
  const JobId single = service.submit(small_scene(), many_leases());
  CHECK(single > 0);
  CHECK(service.state(incomplete) == "done");
  CHECK(contains(service.refusal(msg::ShowJob{1, series}), "no job"));
  CHECK(listed(service).size() == 2);
}

TEST_CASE(
    "a full disk takes an ended series as a whole, so that it does not wait for frames again") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand hand(service, "w");
  const JobId series = submit_series(service, 2);
  work(service, {{&hand, honest}}, series);
  CoordinatorOptions options = service_options();
  options.limits.disk = store.usage().total - 1;  // one frame less would be enough
  Service full(options, &store);
  full.turn();
  full.turn(seconds(6));
  full.turn(seconds(6));
  CHECK(contains(full.refusal(msg::ShowJob{1, series}), "no job"));
  CHECK(listed(full).empty());
}

TEST_CASE("after a restart a series continues under its number") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand hand(service, "w");
  const JobId series = submit_series(service, 3);
  work(service, {{&hand, honest}}, job_of(service, series, 0));
  service.turn();
  service.restart();
  hand.join();
  CHECK(service.job(series).at("frames_done") == 1);
  const JobId again = service.ask<msg::Submitted>(frame_of(service, 2, 3)).job;
  CHECK(again == job_of(service, series, 2));
  work(service, {{&hand, honest}}, series);
  CHECK(service.state(series) == "done");
  const JobId next = service.submit(small_scene(), many_leases());
  CHECK(next > again);
  CHECK(service.sha256(again) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("no worker is idle between frames while there are more") {
  Service service;
  Hand a(service, "a", 2);
  Hand b(service, "b", 2);
  Hand c(service, "c", 2);
  const Hands hands = {{&a, honest}, {&b, honest}, {&c, honest}};
  const JobId series = submit_series(service, 4);
  const JobId last = job_of(service, series, 3);
  round(service, hands);
  round(service, hands);
  std::set<JobId> traced;
  for (int i = 0; i < 500 && service.job(last).at("progress") == 0; ++i) {
    service.turn();
    for (const auto& [hand, manner] : hands) {
      hand->listen();
      hand->beat();
      REQUIRE_FALSE(hand->held.empty());
      traced.insert(hand->held.begin()->first.first);
      manner(*hand, hand->put_down());
    }
    service.turn(Time(0));
  }
  CHECK(traced.size() >= 3);
  work(service, hands, series);
  CHECK(service.state(series) == "done");
}

TEST_CASE("frames take their turns by number, before jobs that came later") {
  Service service;
  service.ask<msg::Submitted>(frame_of(service, 1, 2));
  const JobId later = service.submit(small_scene(), many_leases());
  const JobId zero = service.ask<msg::Submitted>(frame_of(service, 0, 2)).job;
  service.steer(later, msg::JobAction::prioritise, 50);
  Hand hand(service, "w");
  const JobId series = service.job(zero).at("series");
  work(service, {{&hand, honest}}, zero);
  CHECK(service.state(zero) == "done");
  CHECK(service.state(job_of(service, series, 1)) != "done");
}

}  // namespace parray::test
