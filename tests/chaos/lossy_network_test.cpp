// Runs the real coordinator and workers in virtual time on a network that loses, repeats, delays,
// reorders and truncates messages. The picture never changes, and no sample is merged twice.
#include <doctest/doctest.h>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sim_farm.h"
#include "tests/support/trials.h"

namespace parray::test {
namespace {

constexpr Time longest_run = std::chrono::hours(2);

struct Weather {
  SimNetwork::Tally network;
  Coordinator::Tally verdicts;
  std::size_t parts = 0;  ///< leases of which a worker returned a part

  void add(const SimFarm& farm) {
    const auto& n = farm.network.tally();
    network.dropped += n.dropped;
    network.repeated += n.repeated;
    network.truncated += n.truncated;
    network.overtaken += n.overtaken;
    const auto& v = farm.coordinator().tally();
    verdicts.duplicate += v.duplicate;
    verdicts.stale += v.stale;
    verdicts.mismatch += v.mismatch;
    verdicts.malformed += v.malformed;
    parts += farm.parts();
  }
};

/// Returns trials(count) seeds, one for each history: `count` from `first` on, and as many from
/// each 100'000 after it.
std::vector<std::uint64_t> seeds(std::uint64_t first, std::uint64_t count) {
  std::vector<std::uint64_t> all;
  for (std::uint64_t i = 0; i < trials(count); ++i) {
    all.push_back(first + i % count + 100'000 * (i / count));
  }
  return all;
}

RenderSettings settings_for(const Scene& scene, std::uint64_t seed) {
  RenderSettings settings = small_settings(scene);
  settings.schedule = static_cast<SchedulePolicy>(seed % 4);
  settings.row_order = seed % 3 == 0 ? RowOrder::sequential : RowOrder::interleaved;
  return settings;
}

/// Options for histories in which workers die at random, so that no job fails because of it.
CoordinatorOptions whatever_dies() {
  CoordinatorOptions options;
  options.max_failures = 1000;
  options.heartbeat_workers = 1;  // each new or lost worker changes the heartbeat of all
  return options;
}

void check_picture(SimFarm& farm, const Scene& scene, const RenderSettings& settings) {
  CHECK(farm.picture_sha256() == reference_sha256(scene, settings));
  CHECK(farm.audit().complete());
  CHECK(farm.report().at("image_sha256") == farm.picture_sha256());
  CHECK(farm.report().at("samples") ==
        std::uint64_t{settings.width} * settings.height * settings.samples_per_pixel);
}

}  // namespace

TEST_CASE("100 lossy networks: the same hash, every sample merged once") {
  const Scene scene = small_scene();
  Weather weather;
  for (const std::uint64_t seed : seeds(0, 100)) {
    CAPTURE(seed);
    std::mt19937_64 random(seed);
    const auto up_to = [&](double most) {
      return std::uniform_real_distribution<>(0, most)(random);
    };
    const Faults faults{up_to(0.3), up_to(0.3), up_to(0.2),
                        milliseconds(static_cast<int>(up_to(3000)))};
    SimFarm farm(faults, seed);
    const std::size_t workers = 1 + random() % 4;
    for (std::size_t i = 0; i < workers; ++i) farm.add_worker(20 + up_to(500));
    const RenderSettings settings = settings_for(scene, seed);
    farm.submit(scene, settings);
    REQUIRE(farm.run(longest_run));
    check_picture(farm, scene, settings);
    weather.add(farm);
  }
  // Each kind of fault, and each verdict except a mismatch, has happened often.
  CHECK(weather.network.dropped > 500);
  CHECK(weather.network.repeated > 500);
  CHECK(weather.network.truncated > 500);
  CHECK(weather.network.overtaken > 500);
  CHECK(weather.verdicts.malformed > 500);
  CHECK(weather.verdicts.stale > 25);
  // Only results from a holder are compared; results repeated later are stale.
  CHECK(weather.verdicts.duplicate > 5);
  CHECK(weather.verdicts.mismatch == 0);
  CHECK(weather.parts > 50);
}

TEST_CASE("workers that die, hang and join at random moments do not change the picture") {
  const Scene scene = small_scene();
  Weather weather;
  for (const std::uint64_t seed : seeds(1000, 50)) {
    CAPTURE(seed);
    SimFarm farm({0.02, 0.02, 0.01, milliseconds(50)}, seed, 0, whatever_dies());
    std::mt19937_64 random(seed);
    farm.add_worker(100);
    farm.add_worker(30);
    const RenderSettings settings = settings_for(scene, seed);
    farm.submit(scene, settings);
    REQUIRE(farm.run(longest_run, [&](SimFarm& f) {
      const std::size_t victim = random() % f.worker_count();
      if (random() % 200 == 0 && f.alive(victim)) {
        f.kill_worker(victim);
        f.add_worker(20 + static_cast<double>(random() % 200));
      } else if (random() % 200 == 0 && f.alive(victim)) {
        f.stop_worker(victim, f.network.now() + seconds(random() % 40));
      }
    }));
    check_picture(farm, scene, settings);
    weather.add(farm);
  }
  CHECK(weather.parts > 25);
  CHECK(weather.verdicts.stale > 2);  // stopped workers came back too late
}

TEST_CASE(
    "a coordinator killed at any moment, on an often full disk, loses no acknowledged result") {
  const Scene scene = small_scene();
  std::uint64_t crashes = 0;
  std::size_t acknowledged = 0;
  for (const std::uint64_t seed : seeds(2000, 50)) {
    CAPTURE(seed);
    const double failing_commits = seed % 2 == 0 ? 0.1 : 0;
    SimFarm farm({0.02, 0.02, 0.01, milliseconds(50)}, seed, failing_commits);
    std::mt19937_64 random(seed);
    farm.add_worker(100);
    farm.add_worker(150);
    const RenderSettings settings = settings_for(scene, seed);
    farm.submit(scene, settings);
    std::size_t lost = 0;
    REQUIRE(farm.run(longest_run, [&](SimFarm& f) {
      if (random() % 60 == 0) f.crash_coordinator();
      lost += f.acknowledged_but_lost();
    }));
    CHECK(lost == 0);
    check_picture(farm, scene, settings);
    crashes += farm.crashes();
    acknowledged += farm.acknowledged();
  }
  CHECK(crashes > 100);
  CHECK(acknowledged > 150);
}

TEST_CASE(
    "a picture in passes is the same on any network after any crash, and no pass is decided "
    "twice") {
  const Scene scene = small_scene();
  Weather weather;
  std::uint64_t crashes = 0;
  for (const std::uint64_t seed : seeds(3000, 30)) {
    CAPTURE(seed);
    RenderSettings settings = settings_for(scene, seed);
    const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
    settings.adaptive = true;
    settings.progressive = seed % 2 == 0;
    settings.passes = {4 * pixels, 3 * pixels, 2 * pixels};
    SimFarm farm({0.05, 0.05, 0.02, milliseconds(200)}, seed, 0, whatever_dies());
    std::mt19937_64 random(seed);
    farm.add_worker(100);
    farm.add_worker(40);
    farm.submit(scene, settings);
    std::size_t lost = 0;
    REQUIRE(farm.run(longest_run, [&](SimFarm& f) {
      const std::size_t victim = random() % f.worker_count();
      if (random() % 150 == 0) {
        f.crash_coordinator();
      } else if (random() % 300 == 0 && f.alive(victim)) {
        f.kill_worker(victim);
        f.add_worker(20 + static_cast<double>(random() % 200));
      }
      lost += f.acknowledged_but_lost();
    }));
    CHECK(lost == 0);
    CHECK(farm.picture_sha256() == reference_passes_sha256(scene, settings));
    CHECK(farm.audit().complete());
    CHECK(farm.report().at("passes") == settings.passes);
    CHECK(farm.report().at("stopped_by") == "passes");
    weather.add(farm);
    crashes += farm.crashes();
  }
  CHECK(crashes > 50);
  CHECK(weather.verdicts.mismatch == 0);
  CHECK(weather.parts > 25);
}

TEST_CASE("a worker stopped beyond its deadline has its late result refused") {
  const Scene scene = small_scene();
  RenderSettings settings = small_settings(scene);
  settings.schedule = SchedulePolicy::static_split;
  SimFarm farm({}, 7);
  const std::size_t sleeper = farm.add_worker(100);
  farm.submit(scene, settings);
  bool stopped = false;
  REQUIRE(farm.run(longest_run, [&](SimFarm& f) {
    if (!stopped && !f.worker_is_idle(sleeper)) {
      f.stop_worker(sleeper, seconds(30));
      stopped = true;
    }
    // The second worker joins after the coordinator has noticed the loss; otherwise it would hold a
    // copy of the same lease. It is so slow that the job is still running when the stopped worker
    // returns.
    if (f.worker_count() == 1 && f.network.now() > seconds(8)) f.add_worker(20);
  }));
  CHECK(stopped);
  CHECK(farm.coordinator().tally().stale >= 1);
  check_picture(farm, scene, settings);
}

}  // namespace parray::test
