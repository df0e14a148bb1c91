#include "worker/team.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cfenv>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "common/math/float_mode.h"
#include "common/schedule/row_order.h"
#include "common/trace/isa.h"
#include "tests/support/dice.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using test::Dice;
using test::small_scene;
using test::small_settings;

std::shared_ptr<const Scene> shared_scene() {
  static const auto scene = std::make_shared<const Scene>(small_scene());
  return scene;
}

RenderSettings settings_of(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings = small_settings(*shared_scene());
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  return settings;
}

WorkRect whole(const RenderSettings& settings) {
  return {0, settings.height, 0, settings.samples_per_pixel};
}

/// trace_rect() with nobody watching.
RowBlock traced_block(const RenderSettings& settings, const WorkRect& rect, int threads) {
  const auto kernel = make_kernel(*shared_scene(), settings);
  std::atomic<std::uint64_t> traced = 0;
  const std::atomic<bool> stop = false;
  RowBlock block = trace_rect(*kernel, settings, rect, threads, traced, stop);
  CHECK(traced == rect.units() * settings.width);
  return block;
}

/// The same, pixel by pixel and sample by sample, in one thread.
RowBlock plain_block(const RenderSettings& settings, const WorkRect& rect) {
  const auto kernel = make_kernel(*shared_scene(), settings);
  const auto row_at = make_row_order(settings.row_order, settings.height);
  RowBlock block{rect, settings.width, {}, {}};
  for (std::uint32_t row = rect.row_begin; row < rect.row_end; ++row) {
    for (std::uint32_t x = 0; x < settings.width; ++x) {
      PixelSums pixel;
      for (std::uint32_t s = rect.sample_begin; s < rect.sample_end; ++s) {
        kernel->trace({row_at[row], x, x + 1}, {s, s + 1}, {&pixel, 1}, block.counts);
      }
      block.pixels.push_back(pixel);
    }
  }
  return block;
}

/// Counts calls from the team's thread and lets the test wait for them.
class Bell {
 public:
  void ring() {
    {
      const std::scoped_lock lock(mutex_);
      ++rung_;
    }
    changed_.notify_all();
  }
  /// False after a minute: only a broken team takes that long.
  bool wait_for(int count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::minutes(1), [&] { return rung_ >= count; });
  }
  int rung() {
    const std::scoped_lock lock(mutex_);
    return rung_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int rung_ = 0;
};

/// Waits until `condition` holds; false after a minute.
template <typename Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 60'000; ++i) {
    if (condition()) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// Puts the thread into a mode that a careless library might leave behind.
class OtherMode {
 public:
  OtherMode() { std::fesetround(FE_UPWARD); }
  ~OtherMode() { std::fesetround(FE_TONEAREST); }
  OtherMode(const OtherMode&) = delete;
  OtherMode& operator=(const OtherMode&) = delete;
  [[nodiscard]] static bool in_force() { return std::fegetround() == FE_UPWARD; }
};

Assignment assignment(std::uint64_t epoch, const RenderSettings& settings) {
  return {7, epoch, whole(settings), settings, {}, "the small scene", shared_scene()};
}

/// Hours of work, in pieces of a millisecond.
RenderSettings endless() { return settings_of(64, 64, 1U << 20); }

}  // namespace

TEST_CASE("a block has the same bits for any number of threads") {
  for (const RenderSettings& settings :
       {settings_of(20, 13, 6), settings_of(3, 1, 5000), settings_of(300, 2, 16)}) {
    const RowBlock expected = plain_block(settings, whole(settings));
    for (const int threads : {1, 2, 3, 8}) {
      CAPTURE(threads);
      CHECK(traced_block(settings, whole(settings), threads) == expected);
    }
  }
}

TEST_CASE("a single row and a single pixel with many samples keep their bits over threads") {
  const RenderSettings row = settings_of(1000, 9, 8);
  const RenderSettings pixel = settings_of(1, 1, 20'000);
  for (const int threads : {1, 3}) {
    CHECK(traced_block(row, {4, 5, 0, 8}, threads) == plain_block(row, {4, 5, 0, 8}));
    CHECK(traced_block(pixel, whole(pixel), threads) == plain_block(pixel, whole(pixel)));
  }
}

TEST_CASE("pieces of any size cover every sample once: counts are exact") {
  for (const std::uint32_t width : {1U, 7U, 64U, 2047U, 2048U, 2049U}) {
    for (const std::uint32_t spp : {1U, 2U, 3U, 2047U, 2048U, 2049U, 4097U}) {
      if (std::uint64_t{width} * spp > 20'000) {
        continue;
      }
      const RenderSettings settings = settings_of(width, 2, spp);
      const RowBlock block = traced_block(settings, whole(settings), 2);
      CHECK(block.counts.samples == std::uint64_t{2} * width * spp);
      CHECK(block.counts.rays >= block.counts.samples);
      CHECK(block.counts.nonfinite == 0);
    }
  }
}

TEST_CASE("the parts of a rectangle, cut by rows or samples, add up to the whole") {
  Dice dice(1);
  const RenderSettings settings = settings_of(11, 12, 30);
  const RowBlock all = traced_block(settings, whole(settings), 2);
  for (int round = 0; round < 10; ++round) {
    const std::uint32_t row = 1 + dice.below32(11);
    const std::uint32_t sample = 1 + dice.below32(29);
    RowBlock sum{whole(settings), 11, {}, std::vector<PixelSums>(all.pixels.size())};
    for (const WorkRect& part : {WorkRect{0, row, 0, sample}, WorkRect{0, row, sample, 30},
                                 WorkRect{row, 12, 0, sample}, WorkRect{row, 12, sample, 30}}) {
      const RowBlock block = traced_block(settings, part, 1 + static_cast<int>(dice.below(3)));
      CHECK(block.rect == part);
      CHECK(block.pixels.size() == std::size_t{part.rows()} * 11);
      for (std::size_t i = 0; i < block.pixels.size(); ++i) {
        sum.pixels[std::size_t{part.row_begin} * 11 + i] += block.pixels[i];
      }
      sum.counts += block.counts;
    }
    CHECK(sum == all);
  }
}

TEST_CASE("a rectangle's rows are positions of the row order") {
  RenderSettings settings = settings_of(5, 8, 4);
  settings.row_order = RowOrder::interleaved;
  const RowBlock interleaved = traced_block(settings, whole(settings), 2);
  settings.row_order = RowOrder::sequential;
  const RowBlock sequential = traced_block(settings, whole(settings), 2);
  const auto row_at = make_row_order(RowOrder::interleaved, 8);
  for (std::uint32_t position = 0; position < 8; ++position) {
    for (std::uint32_t x = 0; x < 5; ++x) {
      CHECK(interleaved.pixels[position * 5 + x] == sequential.pixels[row_at[position] * 5 + x]);
    }
  }
  CHECK_FALSE(interleaved.pixels == sequential.pixels);
}

TEST_CASE("the floating-point mode of the calling thread does not reach a sample's bits") {
  const RenderSettings settings = settings_of(20, 13, 6);
  const RowBlock expected = plain_block(settings, whole(settings));
  const OtherMode mode;  // from here on, every division rounds up
  SUBCASE("of whoever calls trace_rect") {
    std::atomic<std::uint64_t> traced = 0;
    const std::atomic<bool> stop = false;
    std::unique_ptr<Kernel> kernel;
    {
      const FloatMode ieee;
      kernel = make_kernel(*shared_scene(), settings);
    }
    for (const int threads : {1, 2}) {
      CHECK(trace_rect(*kernel, settings, whole(settings), threads, traced, stop) == expected);
    }
    CHECK(OtherMode::in_force());  // it is given back as it was
  }
  SUBCASE("of whoever makes a team, which builds the kernel too") {
    Bell bell;
    ThreadTeam team(2, [&] { bell.ring(); });
    team.start(assignment(1, settings));
    REQUIRE(bell.wait_for(1));
    CHECK(team.take()->block == expected);
  }
}

TEST_CASE("tracing that is told to stop ends early") {
  const RenderSettings settings = endless();
  const auto kernel = make_kernel(*shared_scene(), settings);
  std::atomic<std::uint64_t> traced = 0;
  std::atomic<bool> stop = true;
  SUBCASE("before it begins") {
    const RowBlock block = trace_rect(*kernel, settings, {0, 1, 0, 4096}, 2, traced, stop);
    CHECK(block.counts.samples == 0);
    CHECK(traced == 0);
  }
  SUBCASE("in the midst") {
    stop = false;
    std::thread stopper([&] {
      eventually([&] { return traced > 0; });
      stop = true;
    });
    const RowBlock block = trace_rect(*kernel, settings, {0, 1, 0, 1U << 20}, 2, traced, stop);
    stopper.join();
    CHECK(block.counts.samples == traced);
    CHECK(traced > 0);
    CHECK(traced < std::uint64_t{64} << 20);
  }
}

TEST_CASE("a team traces an assignment, rings, and hands the result out once") {
  Bell bell;
  ThreadTeam team(2, [&] { bell.ring(); });
  CHECK(team.idle());
  CHECK_FALSE(team.take());
  const RenderSettings settings = settings_of(20, 13, 6);
  team.start(assignment(42, settings));
  CHECK_FALSE(team.idle());
  REQUIRE(bell.wait_for(1));
  CHECK_FALSE(team.idle());  // until the result is taken
  const auto finished = team.take();
  REQUIRE(finished);
  CHECK(finished->job == 7);
  CHECK(finished->epoch == 42);
  CHECK(finished->block == plain_block(settings, whole(settings)));
  CHECK(finished->isa == name_of(best_isa()));
  CHECK(finished->accelerator_bytes > 0);
  CHECK(finished->seconds >= 0);
  CHECK(team.traced() == 20 * 13 * 6);
  CHECK(team.idle());
  CHECK_FALSE(team.take());
}

TEST_CASE("a team goes from scene to scene and from settings to settings") {
  Bell bell;
  ThreadTeam team(1, [&] { bell.ring(); });
  Scene dark = *shared_scene();
  dark.sky = {{0, 0, 0}, {0, 0, 0}};
  const auto dark_scene = std::make_shared<const Scene>(dark);
  int rounds = 0;
  for (const RenderSettings& settings : {settings_of(8, 4, 2), settings_of(4, 8, 2)}) {
    for (const bool is_dark : {false, true, false}) {
      Assignment next = assignment(1, settings);
      if (is_dark) {
        next.scene = dark_scene;
        next.scene_id = "dark";
      }
      team.start(next);
      REQUIRE(bell.wait_for(++rounds));
      const auto finished = team.take();
      REQUIRE(finished);
      CHECK((finished->block == plain_block(settings, whole(settings))) == !is_dark);
      CHECK((finished->block.pixels == std::vector<PixelSums>(32)) == is_dark);
    }
  }
}

TEST_CASE("an abandoned lease leaves no result, and the team takes the next") {
  Bell bell;
  ThreadTeam team(2, [&] { bell.ring(); });
  team.start(assignment(1, endless()));
  SUBCASE("at once") {}
  SUBCASE("while it traces") {
    REQUIRE(eventually([&] { return team.traced() > 0; }));
  }
  team.abandon();
  REQUIRE(bell.wait_for(1));
  REQUIRE(eventually([&] { return team.idle(); }));
  CHECK_FALSE(team.take());
  const std::uint64_t before = team.traced();
  const RenderSettings settings = settings_of(6, 5, 4);
  team.start(assignment(2, settings));
  REQUIRE(bell.wait_for(2));
  const auto finished = team.take();
  REQUIRE(finished);
  CHECK(finished->epoch == 2);
  CHECK(finished->block == plain_block(settings, whole(settings)));
  CHECK(team.traced() == before + 120);
}

TEST_CASE("abandoning an idle team, or a finished lease, does no harm") {
  Bell bell;
  ThreadTeam team(1, [&] { bell.ring(); });
  team.abandon();
  CHECK(team.idle());
  const RenderSettings settings = settings_of(6, 5, 4);
  team.start(assignment(1, settings));
  REQUIRE(bell.wait_for(1));
  team.abandon();  // the result is dropped
  CHECK(team.idle());
  CHECK_FALSE(team.take());
  team.start(assignment(2, settings));
  REQUIRE(bell.wait_for(2));
  REQUIRE(eventually([&] { return !team.idle(); }));
  CHECK(team.take()->epoch == 2);
}

TEST_CASE("many leases started, abandoned and taken in any order neither hang nor mix up") {
  Bell bell;
  ThreadTeam team(2, [&] { bell.ring(); });
  const RenderSettings settings = settings_of(20, 13, 6);
  const RowBlock expected = plain_block(settings, whole(settings));
  Dice dice(2);
  int taken = 0;
  for (std::uint64_t epoch = 1; epoch <= 300; ++epoch) {
    REQUIRE(eventually([&] { return team.idle(); }));
    team.start(assignment(epoch, settings));
    if (dice.one_in(2)) {
      for (std::uint64_t spin = dice.below(3); spin > 0; --spin) {
        std::this_thread::yield();
      }
      team.abandon();
      continue;
    }
    // A bell of an abandoned lease may still be on its way, so the result tells.
    std::optional<Finished> finished;
    REQUIRE(eventually([&] {
      finished = team.take();
      return finished.has_value();
    }));
    REQUIRE(finished->epoch == epoch);
    REQUIRE(finished->block == expected);
    ++taken;
  }
  CHECK(taken > 100);
  CHECK(taken < 200);
}

TEST_CASE("a team that is destroyed while it traces ends") {
  Bell bell;
  {
    ThreadTeam team(2, [&] { bell.ring(); });
    team.start(assignment(1, endless()));
    REQUIRE(eventually([&] { return team.traced() > 0; }));
  }
  CHECK(bell.rung() <= 1);
}

TEST_CASE("a failure to trace is thrown to whoever asks for the result") {
  Bell bell;
  ThreadTeam team(1, [&] { bell.ring(); });
  Assignment broken = assignment(1, settings_of(6, 5, 4));
  // Its sums would take more memory than a vector may have.
  broken.rect = {0, 0xFFFFFFFF, 0, 1};
  broken.settings.width = 0xFFFFFFFF;
  team.start(broken);
  REQUIRE(bell.wait_for(1));
  CHECK_THROWS_AS(team.take(), RunError);
}

}  // namespace parray
