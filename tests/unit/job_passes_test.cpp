// Jobs that go in passes without leases of the coordinator's, as under MPI: all that is pending is
// merged, then the next pass begins.
#include <doctest/doctest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/null_sink.h>

#include <atomic>
#include <memory>
#include <vector>

#include "coordinator/coordinator.h"
#include "proto/messages.h"
#include "tests/support/crash_store.h"
#include "tests/support/sample_scenes.h"
#include "worker/team.h"

namespace parray::test {
namespace {

RenderSettings adaptive_settings() {
  RenderSettings settings = small_settings(small_scene());
  settings.samples_per_pixel = 300;
  settings.adaptive = true;
  return settings;
}

JobRecord record_of(const RenderSettings& settings) {
  JobRecord record;
  record.id = 1;
  record.settings = settings;
  record.scene = scene_identity(scene_to_bytes(small_scene()));
  return record;
}

std::string image_of(const Job& job) {
  return image_sha256(resolve_image(job.work->framebuffer, job.work->largest_radiance));
}

/// One life of a job, which ends with the job or after `blocks` blocks.
struct Life {
  explicit Life(CrashStore& its_store) : store(its_store) {
    job.record = store.jobs().at(0);
    job.take_up(store);
    store.commit();
    epoch = job.first_epoch();
  }

  /// True when the picture is complete. A pass is four blocks or more; the store hears of the next
  /// with its first block, or, `early`, before.
  bool go_on(int blocks, bool early) {
    do {
      for (const WorkRect& all : job.work->leases.pending()) {
        const std::uint32_t step = (all.rows() + 3) / 4;
        for (std::uint32_t row = all.row_begin; row < all.row_end; row += step) {
          if (blocks-- == 0) {
            return false;
          }
          trace({row, std::min(row + step, all.row_end), all.sample_begin, all.sample_end});
        }
      }
      job.note_all_merged();
    } while (next_pass(early));
    return true;
  }

  void trace(const WorkRect& rect) {
    std::atomic<std::uint64_t> done = 0;
    Framebuffer& framebuffer = job.work->framebuffer;
    const RowBlock block = trace_rect(*kernel, job.record.settings, rect, 1, done, false,
                                      framebuffer.samples_of(rect));
    framebuffer.merge(block);
    store.put_job(job.record);
    store.put_block(1, epoch++, row_block_to_bytes(block));
    store.commit();
  }

  bool next_pass(bool early) {
    const bool goes_on = job.next_pass(Time{});
    if (goes_on && early) {
      store.put_job(job.record);
      store.commit();
    }
    return goes_on;
  }

  CrashStore& store;
  Job job;
  std::uint64_t epoch = 0;
  std::unique_ptr<const Kernel> kernel = make_kernel(small_scene(), adaptive_settings());
};

CrashStore new_store(const JobRecord& record) {
  CrashStore store(0, 1);
  store.put_scene(record.scene, scene_to_bytes(small_scene()));
  store.put_job(record);
  store.commit();
  return store;
}

constexpr int for_ever = 1 << 30;

}  // namespace

TEST_CASE(
    "a job that ends at any moment of any pass goes on to the same passes and the same bits") {
  CrashStore undisturbed = new_store(record_of(adaptive_settings()));
  Life whole(undisturbed);
  REQUIRE(whole.go_on(for_ever, false));
  REQUIRE(whole.job.record.passes.size() >= 3);
  const std::string expected = image_of(whole.job);
  for (const bool early : {false, true}) {
    CrashStore store = new_store(record_of(adaptive_settings()));
    int lives = 1;
    for (bool done = false; !done; ++lives) {
      Life life(store);
      done = life.go_on(lives % 5, early);  // a pass may be complete, and the next not begun
      if (done) {
        CHECK(image_of(life.job) == expected);
        CHECK(life.job.record.passes == whole.job.record.passes);
        CHECK(life.job.work->stopped_by == StopReason::samples);
      }
      REQUIRE(lives < 1000);
    }
    CHECK(lives > 5);
  }
}

TEST_CASE("a row of a pass before that was not kept is traced again, and no pass is decided anew") {
  CrashStore undisturbed = new_store(record_of(adaptive_settings()));
  Life whole(undisturbed);
  REQUIRE(whole.go_on(for_ever, false));
  JobRecord record = record_of(adaptive_settings());
  record.passes = whole.job.record.passes;
  record.passes[1] += 100;  // not what would be decided now
  CrashStore store = new_store(record);
  Life(store).go_on(3, false);  // of the first pass's four blocks
  Life life(store);
  REQUIRE(life.job.work->passes == 1);
  REQUIRE(life.go_on(for_ever, false));
  CHECK(life.job.record.passes[1] == record.passes[1]);
  RenderSettings settings = adaptive_settings();
  settings.passes = life.job.record.passes;
  CHECK(image_of(life.job) == reference_passes_sha256(small_scene(), settings));
}

TEST_CASE("a coordinator finishes a job of which everything is kept but the picture") {
  for (const bool in_passes : {false, true}) {
    RenderSettings settings = adaptive_settings();
    settings.adaptive = in_passes;
    CrashStore store = new_store(record_of(settings));
    std::string expected;
    {
      Life life(store);
      REQUIRE(life.go_on(for_ever, true));
      expected = image_of(life.job);
    }
    CoordinatorOptions options;
    Coordinator coordinator(options, store,
                            std::make_shared<spdlog::logger>(
                                "silent", std::make_shared<spdlog::sinks::null_sink_mt>()));
    CHECK_FALSE(store.has_picture(1));
    coordinator.tick(seconds(5));
    coordinator.take_outbox();
    CHECK(store.has_picture(1));
    const JobRecord done = store.jobs().at(0);
    CHECK(done.state == JobState::done);
    CHECK(nlohmann::json::parse(done.report).at("image_sha256") == expected);
  }
}

TEST_CASE("a job with a target says how far it is as soon as its first pass tells") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.target_error = 0.004;
  CrashStore store = new_store(record_of(settings));
  Life life(store);
  std::vector<double> progress{life.job.progress(Time{})};
  CHECK(job_summary(life.job, seconds(1)).at("seconds_left") == -1);
  for (bool goes_on = true; goes_on;) {
    for (const WorkRect& all : life.job.work->leases.pending()) {
      life.trace(all);
    }
    life.job.note_all_merged();
    goes_on = life.next_pass(false);
    progress.push_back(life.job.progress(Time{}));
  }
  REQUIRE(progress.size() >= 4);
  CHECK(progress[0] == 0);
  for (std::size_t pass = 2; pass < progress.size(); ++pass) {
    CHECK(progress[pass] > progress[pass - 1]);
  }
  CHECK(progress[1] > 0.01);
  CHECK(progress[progress.size() - 2] < 1);
  CHECK(life.job.work->stopped_by == StopReason::error);
}

TEST_CASE("a job with a time limit that is taken up between passes does not run away") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.time_limit = 1000;
  CrashStore store = new_store(record_of(settings));
  Life(store).go_on(4, false);  // the first pass, as a whole
  const Life life(store);
  REQUIRE(life.job.record.passes.size() == 2);
  CHECK(life.job.record.passes[1] <= life.job.record.passes[0]);
}

}  // namespace parray::test
