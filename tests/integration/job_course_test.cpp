// What a coordinator says about a job on its way: times, the curve of its error, and the picture of
// a job that did not come to its end.
#include <doctest/doctest.h>

#include <algorithm>

#include "common/scene/settings.h"
#include "coordinator/store/disk_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

using nlohmann::json;

CoordinatorOptions with_clock() {
  CoordinatorOptions options = service_options();
  options.wall_clock = [now = std::make_shared<double>(1e9)] { return *now += 1; };
  return options;
}

RenderSettings towards(double error) {
  RenderSettings settings = small_settings(small_scene());
  settings.samples_per_pixel = 1'000'000;
  settings.adaptive = true;
  settings.target_error = error;
  return settings;
}

std::vector<std::string> history(Service& service, JobId id) {
  std::vector<std::string> lines;
  const json job = service.job(id);
  for (const json& event : job.at("events")) lines.push_back(event.at("what"));
  return lines;
}

msg::ImageData partial(Service& service, JobId id, bool statistics = false) {
  static std::uint64_t requests = 0;  // a repeated one waits until the answer to the first is gone
  return service.ask<msg::ImageData>(msg::Fetch{++requests, id, true, statistics});
}

/// A coordinator with a store on the disk. The test sets its wall clock.
struct TimedService {
  double clock = 1e9;  ///< seconds since 1970
  TemporaryDirectory directory;
  DiskStore store{directory.path()};
  Service service{options(), &store};

  CoordinatorOptions options() {
    CoordinatorOptions result = service_options();
    result.wall_clock = [this] { return clock; };
    return result;
  }
};

double oldest_queued_seconds(Service& service) {
  return service.ask<msg::Farm>(msg::ShowFarm{1}).farm.at("oldest_queued_seconds");
}

}  // namespace

TEST_CASE("the curve of the error has a point for each pass, and survives a restart") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(with_clock(), &store);
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), towards(0.004));
  double shown = 0;
  while (service.state(id) != "done") {
    const double progress = service.job(id).at("progress");
    CHECK(progress >= shown);
    shown = progress;
    work(service, {{&hand, honest}}, id, 1);
  }
  const json curve = service.job(id).at("passes");
  REQUIRE(curve.size() >= 3);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    CHECK(curve[i].at("samples") > curve[i - 1].at("samples"));
    CHECK(curve[i].at("seconds") >= curve[i - 1].at("seconds"));
    CHECK(curve[i].at("rmse").is_number());
  }
  CHECK(curve.back().at("rmse") == service.job(id).at("error").at("rmse"));
  CHECK(service.job(id).at("ended_by") == "target_error");
  service.restart();
  CHECK(service.job(id).at("passes") == curve);
  CHECK(service.job(id).at("ended_by") == "target_error");
}

TEST_CASE("a done job has its times, also after a restart") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(with_clock(), &store);
  const JobId id = service.submit(small_scene(), many_leases());
  CHECK(service.job(id).at("started").is_null());
  Hand hand(service, "a", 4);
  work(service, {{&hand, honest}}, id);
  const json job = service.job(id);
  CHECK(job.at("submitted") > 1e9);
  CHECK(job.at("started") > job.at("submitted"));
  CHECK(job.at("finished") > job.at("started"));
  CHECK(job.at("seconds_taken") > 0);
  CHECK(job.at("samples_taken") == 4);
  CHECK(job.at("has_picture") == true);
  service.restart();
  for (const char* key :
       {"submitted", "started", "finished", "seconds_taken", "samples_taken", "has_picture"}) {
    CHECK(service.job(id).at(key) == job.at(key));
  }
}

TEST_CASE("the rates of a report count only the samples since the restart of the coordinator") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(with_clock(), &store);
  const JobId id = service.submit(small_scene(), many_leases());
  {
    Hand hand(service, "a");
    work(service, {{&hand, honest}}, id, 5);
  }
  service.turn(seconds(10));  // commits
  service.coordinator().keep_progress();
  service.restart();
  const RenderSettings settings = many_leases();
  const double earlier = service.job(id).at("samples_taken").get<double>() *
                         static_cast<double>(pixel_count(settings));
  REQUIRE(earlier > 0);
  Hand hand(service, "b");
  work(service, {{&hand, honest}}, id);
  const json report = service.fetch(id).report;
  const double seconds = report.at("seconds").at("render").get<double>() -
                         report.at("seconds").at("build").get<double>();
  const double later = report.at("samples").get<double>() - earlier;
  CHECK(later > 0);
  CHECK(report.at("samples_per_second") == doctest::Approx(later / seconds));
  CHECK(report.at("rays_per_second").get<double>() ==
        doctest::Approx(report.at("rays").get<double>() / report.at("samples").get<double>() *
                        later / seconds));
}

TEST_CASE("the error of a running job without a target is estimated on its way") {
  Service service(with_clock());
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), in_passes());
  while (service.job(id).at("samples_taken") < 4) work(service, {{&hand, honest}}, id, 1);
  CHECK_FALSE(service.job(id).contains("error"));
  work(service, {{&hand, idle}}, id, 6, seconds(1));
  const json job = service.job(id);
  REQUIRE(job.at("state") == "running");
  CHECK(job.at("error").at("rmse").is_number());
  CHECK(job.at("passes").size() == 1);
}

TEST_CASE("a cancelled job keeps its progress and serves its picture from its log") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(with_clock(), &store);
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, id, 5);
  const json before = service.job(id);
  const auto running = partial(service, id);
  REQUIRE(before.at("progress") > 0);
  service.steer(id, msg::JobAction::cancel);
  for (const bool restarted : {false, true}) {
    CAPTURE(restarted);
    if (restarted) service.restart();
    const json job = service.job(id);
    CHECK(job.at("progress") == before.at("progress"));
    CHECK(job.at("samples_taken") == before.at("samples_taken"));
    CHECK(job.at("has_picture") == true);
    const auto kept = partial(service, id);
    CHECK(kept.report == running.report);
    CHECK(kept.picture.bytes(PictureDetail::image).data.view() ==
          running.picture.bytes(PictureDetail::image).data.view());
  }
  CHECK(service.refusal(msg::Fetch{1, id, false, false}).find("parray fetch --partial") !=
        std::string::npos);
}

TEST_CASE("without a store a cancelled job keeps its picture until it is queued again") {
  Service service(with_clock());
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, id, 5);
  const auto running = partial(service, id);
  service.steer(id, msg::JobAction::cancel);
  service.turn();
  CHECK(service.job(id).at("has_picture") == true);
  const auto kept = partial(service, id, true);
  CHECK(kept.report == running.report);
  CHECK(kept.picture.picture(kept.width, kept.height)->image.rgb ==
        running.picture.picture(running.width, running.height)->image.rgb);
  service.steer(id, msg::JobAction::requeue);
  CHECK(service.job(id).at("progress") == 0);
  CHECK(service.job(id).at("has_picture") == false);
}

TEST_CASE("a job cancelled before its first sample has no picture, and says so") {
  Service service(with_clock());
  const JobId id = service.submit(small_scene(), many_leases());
  service.steer(id, msg::JobAction::cancel);
  CHECK(service.job(id).at("has_picture") == false);
  CHECK(service.refusal(msg::Fetch{1, id, true, false}).find("no picture of it is kept") !=
        std::string::npos);
}

TEST_CASE("a request for replicates adds nothing to the picture of a job that is not done") {
  for (const bool stored : {false, true}) {
    CAPTURE(stored);
    const TemporaryDirectory directory;
    DiskStore store(directory.path());
    Service service(with_clock(), stored ? &store : nullptr);
    Hand hand(service, "a", 4);
    RenderSettings settings = many_leases();
    settings.replicates = true;
    const JobId id = service.submit(small_scene(), settings);
    work(service, {{&hand, honest}}, id, 5);
    for (const bool cancelled : {false, true}) {
      CAPTURE(cancelled);
      if (cancelled) service.steer(id, msg::JobAction::cancel);
      service.turn();
      const auto data = service.ask<msg::ImageData>(msg::Fetch{1, id, true, false, true});
      REQUIRE(data.width > 0);
      CHECK_FALSE(data.statistics);
      CHECK_FALSE(data.replicates);
    }
  }
}

TEST_CASE("the half-widths of a running picture can be fetched") {
  Service service(with_clock());
  Hand hand(service, "a", 4);
  RenderSettings settings = in_passes();
  const JobId id = service.submit(small_scene(), settings);
  while (service.job(id).at("samples_taken") < 5) work(service, {{&hand, honest}}, id, 1);
  const auto data = partial(service, id, true);
  CHECK(data.statistics);
  const auto parts = data.picture.picture(data.width, data.height);
  CHECK(std::ranges::all_of(parts->statistics.half_width,
                            [](float width) { return width >= 0 && width < 1e3F; }));
  CHECK(std::ranges::all_of(parts->statistics.samples, [](auto n) { return n >= 4; }));
}

TEST_CASE("the history says when the coordinator was started again, and a cancel once") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  Service service(with_clock(), &store);
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, id, 2);
  service.restart();
  hand.join();
  service.turn();
  service.steer(id, msg::JobAction::cancel);
  CHECK(history(service, id) == std::vector<std::string>{"submitted", "started",
                                                         "the coordinator was started again",
                                                         "continued", "cancelled by a client"});
}

TEST_CASE("a pause by a client does not lower a job's speed or lengthen its time left") {
  Service service(with_clock());
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, id, 5);
  service.steer(id, msg::JobAction::pause);
  const json before = service.job(id);
  REQUIRE(before.at("samples_per_second") > 0);
  service.turn(seconds(600));
  for (const bool resumed : {false, true}) {
    CAPTURE(resumed);
    if (resumed) service.steer(id, msg::JobAction::resume);
    const json job = service.job(id);
    CHECK(job.at("samples_per_second") == before.at("samples_per_second"));
    CHECK(job.at("seconds_left") == before.at("seconds_left"));
  }
}

TEST_CASE("the wait of a job that was queued again begins then, also after a restart") {
  TimedService timed;
  Service& service = timed.service;
  const JobId id = service.submit(small_scene(), many_leases());
  service.steer(id, msg::JobAction::cancel);
  timed.clock += 86400;
  service.steer(id, msg::JobAction::requeue);
  service.turn();
  timed.clock += 60;
  service.restart();
  service.turn();
  CHECK(oldest_queued_seconds(service) == doctest::Approx(60));
}

TEST_CASE("a restart does not lose the wait of a job that was paused before its first lease") {
  TimedService timed;
  Service& service = timed.service;
  const JobId id = service.submit(small_scene(), many_leases());
  service.steer(id, msg::JobAction::pause);
  service.turn();
  timed.clock += 60;
  service.restart();
  service.turn();
  CHECK(oldest_queued_seconds(service) == 0);  // a paused job is not queued
  service.steer(id, msg::JobAction::resume);
  service.turn();
  CHECK(oldest_queued_seconds(service) == doctest::Approx(60).epsilon(0.01));
}

TEST_CASE("after a restart, a resumed job that had leases does not wait for its first one") {
  TimedService timed;
  Service& service = timed.service;
  Hand hand(service, "a", 4);
  const JobId id = service.submit(small_scene(), many_leases());
  work(service, {{&hand, honest}}, id, 2);
  service.steer(id, msg::JobAction::pause);
  service.restart();
  service.steer(id, msg::JobAction::resume);
  service.turn();
  timed.clock += 60;
  service.restart();
  service.turn();
  CHECK(service.state(id) == "queued");
  CHECK(oldest_queued_seconds(service) == 0);
}

}  // namespace parray::test
