// A job's picture and the log from which a later process resumes it.
#include "coordinator/jobs/job_picture.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"
#include "tests/support/with_value.h"

namespace parray {
namespace {

using test::Dice;
using test::faulty_tracer;
using test::honest_tracer;
using test::made_cells;
using test::made_in_one_pass;
using test::made_in_passes;
using test::with_value;
using Log = std::vector<std::string>;

/// A job's picture in one process, and its log.
struct PictureLife {
  explicit PictureLife(const RenderSettings& settings, const Log& its_log = {},
                       std::vector<std::uint64_t> begun = {})
      : picture(settings, SceneFacts(test::small_scene()), std::move(begun)), log(its_log) {
    for (const std::string& entry : log) picture.replay(entry);
    picture.end_replay();
    if (!picture.has_begun() || picture.collector().done()) complete = !picture.begin_pass();
  }

  void take(TracerKey tracer, const CellRange& range) {
    TracedCells cells = made_cells(picture.plan()->batch(range));
    if (tracer == faulty_tracer) {
      test::falsify(cells, record_bytes(picture.plan()->grid()->shape().cell_pixels));
    }
    picture.collector().take(tracer, cells);
    log.push_back(JobPicture::cells_entry(picture.passes().pass(), tracer, range,
                                          pack_cells(cells, *picture.plan()->grid())));
  }
  /// Returns some of the missing cells of the pass.
  void take_some(Dice& dice, TracerKey tracer = honest_tracer) {
    const auto missing = picture.collector().missing();
    const CellRange& all = missing[dice.below(missing.size())];
    const std::uint64_t begin = all.begin + dice.below(all.count());
    take(tracer, {begin, begin + 1 + dice.below(all.end - begin)});
  }
  void take_missing() {
    for (const CellRange& range : picture.collector().missing()) take(honest_tracer, range);
  }
  void finish() {
    while (!complete) {
      take_missing();
      complete = !picture.begin_pass();
    }
  }
  [[nodiscard]] const Framebuffer& framebuffer() const { return picture.framebuffer(); }

  JobPicture picture;
  Log log;
  bool complete = false;
};

}  // namespace

TEST_CASE("a resumed picture has the same sums, however the pass was cut") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    PictureLife life(made_in_one_pass());
    for (std::uint64_t i = 1 + dice.below(10); i > 0 && !life.picture.collector().done(); --i) {
      life.take_some(dice, 1 + dice.below(3));
    }
    PictureLife next(made_in_one_pass(), life.log);
    CHECK(test::same_sums(next.framebuffer(), life.framebuffer()));
    CHECK(next.picture.collector().missing() == life.picture.collector().missing());
    CHECK(next.picture.collector().tracers() == life.picture.collector().tracers());
    next.finish();
    CHECK(test::same_sums(next.framebuffer(), test::made_framebuffer(made_in_one_pass())));
  }
}

TEST_CASE("a job that is resumed at any point of any pass gets the same passes and bits") {
  PictureLife whole(made_in_passes());
  whole.finish();
  const auto passes = whole.picture.passes().begun();
  REQUIRE(passes.size() >= 3);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    Log log;
    std::vector<std::uint64_t> begun;
    bool complete = false;
    for (int lives = 0; !complete; ++lives) {
      REQUIRE(lives < 1000);
      PictureLife life(made_in_passes(), log, begun);
      for (std::uint64_t entries = dice.below(6); entries > 0 && !life.complete; --entries) {
        if (!life.picture.collector().done()) {
          life.take_some(dice);
        } else if (dice.one_in(2)) {
          life.complete = !life.picture.begin_pass();
        }
      }
      log = life.log;
      begun = life.picture.passes().begun();
      complete = life.complete;
      if (complete) {
        CHECK(begun == passes);
        CHECK(test::same_sums(life.framebuffer(), whole.framebuffer()));
      }
    }
  }
}

TEST_CASE("a resumed picture keeps retractions and ends with the same bits") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    PictureLife life(made_in_one_pass());
    for (int i = 0; i < 6 && !life.picture.collector().done(); ++i) {
      life.take_some(dice, i == 0 || dice.one_in(3) ? faulty_tracer : honest_tracer);
    }
    CHECK(life.picture.relies_on(faulty_tracer));
    const auto retraction = life.picture.retract(faulty_tracer);
    CHECK_FALSE(retraction.restarted);
    CHECK_FALSE(retraction.cells.empty());
    CHECK_FALSE(life.picture.relies_on(faulty_tracer));
    life.log.push_back(life.picture.retraction_entry(retraction.cells));
    life.take_some(dice);
    PictureLife next(made_in_one_pass(), life.log);
    CHECK(test::same_sums(next.framebuffer(), life.framebuffer()));
    next.finish();
    CHECK(test::same_sums(next.framebuffer(), test::made_framebuffer(made_in_one_pass())));
  }
}

TEST_CASE("a picture in passes restarts if a faulty worker traced a part of any pass") {
  PictureLife whole(made_in_passes());
  whole.finish();
  for (const int lying_pass : {0, 1}) {
    PictureLife life(made_in_passes());
    for (int pass = 0; pass < 2; ++pass) {
      if (pass == lying_pass) life.take(faulty_tracer, {1, 3});
      life.take_missing();
      life.picture.begin_pass();
    }
    CHECK(life.picture.relies_on(faulty_tracer));
    CHECK_FALSE(life.picture.relies_on(99));
    const auto retraction = life.picture.retract(faulty_tracer);
    CHECK(retraction.restarted);
    CHECK(retraction.cells == std::vector<CellRange>{{0, life.picture.plan()->cells()}});
    CHECK(life.picture.passes().pass() == 0);
    CHECK(life.framebuffer().counts() == TraceCounts{});
    CHECK_FALSE(life.picture.relies_on(faulty_tracer));
    life.finish();
    CHECK(test::same_sums(life.framebuffer(), whole.framebuffer()));
    CHECK(life.picture.passes().begun() == whole.picture.passes().begun());
  }
}

TEST_CASE("replay refuses entries that no process can have written") {
  PictureLife life(made_in_one_pass());
  life.take(honest_tracer, {2, 5});
  const std::string entry = life.log.front();
  const auto refused = [](const std::string& damaged) {
    PictureLife fresh(made_in_one_pass());
    CHECK_THROWS_AS(fresh.picture.replay(damaged), DecodeError);
  };
  for (std::size_t size = 0; size < entry.size(); ++size) refused(entry.substr(0, size));
  refused(entry + '\0');
  refused(with_value(entry, 0, std::uint32_t{3}));  // unknown kind
  refused(with_value(entry, 4, std::uint32_t{1}));  // a pass that has not begun
  refused(with_value(entry, 4, UINT32_MAX));
  refused(with_value(entry, 16, std::uint64_t{5}));  // no cells
  refused(with_value(entry, 16, std::uint64_t{6}));
  refused(with_value(entry, 24, life.picture.plan()->cells() + 1));
  refused(with_value(entry, 24, UINT64_MAX));
  refused(with_value(entry, 24, std::uint64_t{6}));  // more cells than the entry holds
  const std::string retraction = life.picture.retraction_entry({{2, 4}});
  refused(retraction.substr(0, retraction.size() - 1));
  refused(with_value(retraction, 8, std::uint64_t{4}));
  refused(with_value(retraction, 16, UINT64_MAX));
}

TEST_CASE("an unfinished picture needs no more memory than memory() returns") {
  const auto of = [](std::uint32_t side, bool passes) {
    RenderSettings settings = passes ? made_in_passes() : made_in_one_pass();
    settings.width = settings.height = side;
    return JobPicture::memory(settings);
  };
  CHECK(of(4096, false) >= 4096 * 4096 * 76ULL);  // the framebuffer alone
  CHECK(of(4096, false) < 4096 * 4096 * 250ULL);
  CHECK(of(4096, true) > of(4096, false));
  CHECK(of(1, false) > 0);
  RenderSettings largest = made_in_one_pass();
  largest.width = largest.height = 8192;
  REQUIRE(std::uint64_t{largest.width} * largest.height == limits::max_pixels);
  CHECK(JobPicture::memory(largest) > JobPicture::memory(made_in_one_pass()));
}

TEST_CASE("tracer_key() depends only on name and instance, and differs between processes") {
  CHECK(tracer_key("node 1", "123") == tracer_key("node 1", "123"));
  CHECK(tracer_key("node 1", "123") != tracer_key("node 1", "124"));
  CHECK(tracer_key("node 1", "123") != tracer_key("node 2", "123"));
  CHECK(tracer_key("node 1", "23") != tracer_key("node ", "123"));
}

}  // namespace parray
