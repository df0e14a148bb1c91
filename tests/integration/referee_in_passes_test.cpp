// The referee with jobs in passes and series: its answers are late, and still decide correctly.
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

/// A farm with a slow referee.
struct Farm {
  /// `share` of the leases is checked, and `by_referee` is the referee's share of these checks.
  explicit Farm(Time delay, Store* store = nullptr, double share = 1, double by_referee = 1) {
    options.checks.share = share;
    options.checks.referee_share = by_referee;
    options.referee = referee;
    options.refereeing.burst = 1e6;
    referee->ailments.delay = delay;
    service = std::make_unique<Service>(options, store);
    clock_ = service.get();
  }

 private:
  Service* clock_ = nullptr;

 public:
  std::shared_ptr<SimReferee> referee =
      std::make_shared<SimReferee>([this] { return clock_ == nullptr ? Time{} : clock_->now(); });
  CoordinatorOptions options = service_options();
  std::unique_ptr<Service> service;
};

/// Returns wrong results for the first leases.
Manner lying_at_first(int leases) {
  return [left = std::make_shared<int>(leases)](Hand& hand, const msg::Grant& grant) {
    (*left)-- > 0 ? hand.send_other_picture(grant) : hand.send_honest(grant);
  };
}

/// Returns right results until a number of leases was traced.
Manner lying_later(int leases) {
  return [left = std::make_shared<int>(leases)](Hand& hand, const msg::Grant& grant) {
    (*left)-- > 0 ? hand.send_honest(grant) : hand.send_other_picture(grant);
  };
}

std::vector<JobId> submit_frames(Service& service, std::uint32_t frames) {
  std::vector<JobId> jobs;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    RenderSettings settings = many_leases();
    settings.seed = frame;
    msg::Submit submit = service.submission(small_scene(), settings);
    submit.token = "dance" + std::to_string(frame);
    submit.series = "dance";
    submit.frame = frame;
    submit.frames = frames;
    jobs.push_back(service.ask<msg::Submitted>(submit).job);
  }
  return jobs;
}

RenderSettings settings_of_frame(std::size_t frame) {
  RenderSettings settings = many_leases();
  settings.seed = frame;
  return settings;
}

}  // namespace

TEST_CASE("no pass decides the next one while the referee checks its leases") {
  for (const int delay : {0, 40, 900}) {  // milliseconds
    for (const int honest_leases : {delay == 40 ? 5 : 0, delay == 40 ? 20 : 12}) {
      CAPTURE(delay);
      CAPTURE(honest_leases);
      Farm farm{milliseconds(delay)};
      Hand ann(*farm.service, "ann");
      Hand faulty(*farm.service, "faulty");
      const JobId job = farm.service->submit(small_scene(), in_passes());
      work(*farm.service, {{&ann, honest}, {&faulty, lying_later(honest_leases)}}, job, 5000);
      check_right(*farm.service, job, in_passes());
      CHECK(farm.service->worker("ann").at("state") == "ready");
    }
  }
}

TEST_CASE("correct workers of a job in passes are not judged faulty, however slow the referee is") {
  for (const int delay : {0, 15, 300, 2000}) {
    CAPTURE(delay);
    Farm farm{milliseconds(delay), nullptr, 0.3};
    Hand ann(*farm.service, "ann");
    Hand bob(*farm.service, "bob");
    const JobId job = farm.service->submit(small_scene(), in_passes());
    work(*farm.service, {{&ann, honest}, {&bob, in_parts(1)}}, job, 5000);
    check_right(*farm.service, job, in_passes());
    CHECK(farm.referee->asked > 0);
    for (const char* name : {"ann", "bob"}) {
      CHECK(farm.service->worker(name).at("state") == "ready");
    }
    CHECK(farm.service->job(job).at("flag") == "");
  }
}

TEST_CASE("the referee finds a faulty machine that works alone in any pass") {
  for (const int lies_from : {0, 3, 8, 12}) {
    CAPTURE(lies_from);
    CrashStore store(0, 1);
    Farm farm(milliseconds(50), &store);
    Hand faulty(*farm.service, "faulty");
    const JobId job = farm.service->submit(small_scene(), in_passes());
    work(*farm.service, {{&faulty, lying_later(lies_from)}}, job, 500);
    CHECK(farm.service->state(job) == "running");
    CHECK(farm.service->worker("faulty").at("state") == "quarantined");
    farm.service->restart();
    Hand ann(*farm.service, "ann");
    work(*farm.service, {{&ann, honest}}, job, 5000);
    check_right(*farm.service, job, in_passes());
  }
}

TEST_CASE("results of a faulty worker are undone in all unfinished frames of a series") {
  for (const int delay : {0, 40, 900}) {
    CAPTURE(delay);
    Farm farm{milliseconds(delay)};
    Service& service = *farm.service;
    Hand ann(service, "ann");
    Hand faulty(service, "faulty", 4);
    const std::vector<JobId> frames = submit_frames(service, 4);
    const Hands hands{{&faulty, lying_at_first(6)}, {&ann, honest}};
    for (const JobId frame : frames) work(service, hands, frame, 10'000);
    CHECK(service.worker("faulty").at("state") == "quarantined");
    CHECK(service.worker("ann").at("state") == "ready");
    for (std::size_t frame = 0; frame < frames.size(); ++frame) {
      CAPTURE(frame);
      check_right(service, frames[frame], settings_of_frame(frame));
    }
  }
}

TEST_CASE("a frame that waits for the referee blocks no other frame") {
  Farm farm(Time(0), nullptr, 1, 0);
  Service& service = *farm.service;
  farm.referee->ailments.failure = "it was killed by signal 9";
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand faulty(service, "faulty");
  const std::vector<JobId> frames = submit_frames(service, 3);
  const Hands honest_ones{{&ann, honest}, {&bob, honest}};
  const Hands all{{&faulty, lying_loudly}, {&ann, honest}, {&bob, honest}};
  for (int i = 0; i < 100 && service.state(frames[0]) != "paused"; ++i) {
    work(service, all, frames[0], 1, seconds(1));
  }
  REQUIRE(service.state(frames[0]) == "paused");
  work(service, honest_ones, frames[1], 500, milliseconds(100));
  work(service, honest_ones, frames[2], 500, milliseconds(100));
  check_right(service, frames[1], settings_of_frame(1));
  check_right(service, frames[2], settings_of_frame(2));
  CHECK(service.state(frames[0]) == "paused");
  farm.referee->ailments = {};
  work(service, honest_ones, frames[0], 1000, seconds(1));
  check_right(service, frames[0], settings_of_frame(0));
}

}  // namespace parray::test
