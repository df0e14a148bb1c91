// The referee as a real process.
#include "coordinator/disputes/referee_process.h"

#include <doctest/doctest.h>

#include <atomic>
#include <thread>

#include "common/scene/settings.h"
#include "common/schedule/traced_cells.h"
#include "common/schedule/work_plan.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/clock.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "worker/cell_tracer.h"

namespace parray::test {
namespace {

struct Asked {
  explicit Asked(const std::filesystem::path& program = {},
                 const std::string& fingerprint = trace_fingerprint())
      : referee({program, fingerprint, [this] { ++woken; }}) {}

  Referee::Question question(std::uint64_t id, const CellRange& range) {
    const ScenePayload payload(std::make_shared<const Scene>(scene));
    return {id, payload.identity(), payload, settings, plan.batch(range), std::uint64_t{1} << 30};
  }
  /// Waits for the next answer. Returns an answer without a number after a minute.
  Referee::Answer answer() {
    const SteadyClock clock;
    const Time end = clock.now() + seconds(60);
    while (clock.now() < end) {
      auto answers = referee.take_answers();
      if (!answers.empty()) return std::move(answers.front());
      std::this_thread::sleep_for(milliseconds(1));
    }
    return {};
  }
  Referee::Answer ask(std::uint64_t id, const CellRange& range) {
    referee.ask(question(id, range));
    return answer();
  }

  Scene scene = small_scene();
  RenderSettings settings = [] {
    RenderSettings made = small_settings(small_scene());
    made.samples_per_pixel = 4;
    return made;
  }();
  WorkPlan plan{settings, Pass{{{0, 4}}, {}}};
  std::atomic<int> woken = 0;
  RefereeProcess referee;  ///< last: its thread uses what stands above
};

}  // namespace

TEST_CASE("the referee's process traces the same bits as a worker, for each question") {
  Asked asked;
  for (std::uint64_t id = 1; id <= 3; ++id) {
    const CellRange range{id, id + 2};
    Referee::Answer answer = asked.ask(id, range);
    CHECK(answer.failure.empty());
    CHECK(answer.id == id);
    CHECK(answer.seconds > 0);
    CHECK(answer.memory > 0);
    std::atomic<std::uint64_t> count = 0;
    const TracedCells expected = trace_cells(*make_path_tracer(asked.scene, asked.settings),
                                             asked.plan.batch(range), 1, count, false);
    const std::size_t size = record_bytes(asked.plan.grid()->shape().cell_pixels);
    const auto cells = answer.cells.open(asked.plan.batch(range), asked.settings.max_depth);
    CHECK(cell_digests(cells->records, size) == cell_digests(expected.records, size));
  }
  CHECK(asked.woken == 3);
}

TEST_CASE("a cancelled question gets no answer, and the next one does") {
  Asked asked;
  asked.referee.ask(asked.question(1, {0, 2}));
  asked.referee.forget();
  asked.referee.ask(asked.question(2, {0, 2}));
  Referee::Answer answer = asked.answer();
  if (answer.id == 0) {  // what the first one took
    answer = asked.answer();
  }
  CHECK(answer.id == 2);
  CHECK(answer.failure.empty());
}

TEST_CASE("a referee that was told to forget answers the next question") {
  Asked asked;
  for (const std::uint64_t id : {1U, 2U, 3U}) {
    CHECK(asked.ask(id, {0, 2}).failure.empty());
    asked.referee.forget();
  }
}

TEST_CASE("a referee that is missing, dies or traces other bits is reported") {
  Asked missing("/nonexistent/parray-referee");
  CHECK(missing.ask(1, {0, 1}).failure.find("has no executable") != std::string::npos);
  Asked dying("/bin/false");
  CHECK(dying.ask(1, {0, 1}).failure.find("ended with status 1") != std::string::npos);
  Asked strange({}, "another fingerprint");
  CHECK(strange.ask(1, {0, 1}).failure.find("another release") != std::string::npos);
}

}  // namespace parray::test
