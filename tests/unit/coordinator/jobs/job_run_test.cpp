// A job from begin to finish, with crashes, damaged logs and faulty machines.
#include "coordinator/jobs/job_run.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/machines.h"
#include "coordinator/jobs/report.h"
#include "tests/support/crash_store.h"
#include "tests/support/dice.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::CrashStore;
using test::faulty_tracer;
using test::honest_tracer;
using test::made_cells;
using test::made_in_one_pass;
using test::made_in_passes;
using test::rows_of;

constexpr JobId only_job = 1;

/// A disk with one job that has no results yet.
struct OneJob : CrashStore {
  explicit OneJob(const RenderSettings& settings) : CrashStore(0, 1) {
    JobRecord record;
    record.id = only_job;
    record.settings = settings;
    record.scene = test::digest('a');
    put_job(record);
    commit();
  }
  JobRecord record() { return jobs().front(); }
};

/// A run of the job in the store. It replays the log and begins the pass that is due.
struct RunLife : JobRun {
  explicit RunLife(OneJob& store) : RunLife(store, JobRun(store.record(), &store)) {}
  RunLife(OneJob& store, JobRun its_run) : JobRun(std::move(its_run)), disk(store) {
    create_picture(SceneFacts(test::small_scene()));
    damage = replay(OnDamage::cut);
    complete = !begin_pass({}, 1e9);
  }
  void trace(const CellRange& range, TracerKey tracer = honest_tracer) {
    const TracedCells cells = made_cells(picture().plan()->batch(range));
    take(tracer, cells, pack_cells(cells, *picture().plan()->grid()));
  }
  void trace_missing() {
    for (const CellRange& range : picture().collector().missing()) trace(range);
  }
  void trace_all() {
    while (!complete) {
      trace_missing();
      complete = !begin_pass({}, 1e9);
    }
  }
  void finish() {
    const FinishedPicture made = finish_picture(picture(), record(), {});
    JobRun::finish(made.picture.image, made.picture.statistics, made.report,
                   picture().journal().bytes());
  }
  std::uint64_t samples() { return picture().framebuffer().counts().samples; }

  OneJob& disk;
  std::string damage;
  bool complete = false;
};

/// A run like that of parray-mpi: it buffers results and opens the store when it saves them.
struct Deferred {
  explicit Deferred(OneJob& store)
      : run(store.record(), nullptr, [this, &store] {
          ++opened;
          return &store;
        }) {
    run.create_picture(SceneFacts(test::small_scene()));
    run.begin_pass();
  }
  void trace(const CellRange& range) {
    TracedCells cells = made_cells(run.picture().plan()->batch(range));
    run.picture().collector().take(honest_tracer, cells);
    run.keep(honest_tracer, std::move(cells));
  }
  int opened = 0;
  JobRun run;
};

}  // namespace

TEST_CASE("a run continues from the last commit of the run before") {
  OneJob store(made_in_one_pass());
  std::uint64_t committed = 0;
  {
    RunLife first(store);
    CHECK(first.samples_before() == 0);
    first.trace({0, 3});
    first.commit();
    committed = first.samples();
    first.trace({5, 8});
  }
  store.crash();
  RunLife second(store);
  CHECK(second.damage.empty());
  CHECK(second.samples() == committed);
  CHECK(second.samples_before() == committed);
  second.trace_all();
  CHECK(
      test::same_sums(second.picture().framebuffer(), test::made_framebuffer(made_in_one_pass())));
}

TEST_CASE("a run that crashes at any moment repeats its passes and begins each once") {
  OneJob undisturbed(made_in_passes());
  RunLife whole(undisturbed);
  whole.trace_all();
  REQUIRE(whole.record().passes.size() >= 3);
  OneJob store(made_in_passes());
  test::Dice dice(7);
  for (bool complete = false; !complete;) {
    RunLife life(store);
    for (std::uint64_t steps = 1 + dice.below(4); steps > 0 && !life.complete; --steps) {
      const auto missing = life.picture().collector().missing();
      const CellRange& range = missing[dice.below(missing.size())];
      life.trace({range.begin, range.begin + 1 + dice.below(range.count())});
      life.complete = !life.begin_pass({}, 1e9);
      if (dice.one_in(2)) life.commit();
    }
    complete = life.complete;
    if (complete) {
      CHECK(life.record().passes == whole.record().passes);
      CHECK(test::same_sums(life.picture().framebuffer(), whole.picture().framebuffer()));
      std::vector<std::uint32_t> begun;
      for (const auto& entry : read_journal(life.picture().journal().bytes())) {
        if (const auto* pass = std::get_if<JournalPass>(&entry)) begun.push_back(pass->pass);
      }
      CHECK(std::ranges::adjacent_find(begun, std::greater_equal()) == begun.end());
    }
    store.crash();
  }
}

TEST_CASE("a commit writes the buffered results to the store in their order") {
  OneJob store(made_in_one_pass());
  Deferred life(store);
  life.trace({0, 4});
  life.run.picture().retract(honest_tracer);
  life.run.keep_retraction({{0, 4}});
  life.trace({2, 6});
  CHECK_FALSE(life.run.buffer_full());
  CHECK(life.opened == 0);
  CHECK(rows_of(store, only_job).empty());
  life.run.commit();
  CHECK(life.opened == 1);
  CHECK(store.committed_rows(only_job).size() == 3);
  CHECK_FALSE(life.run.pack_next());
  store.crash();
  RunLife next(store);
  CHECK(next.picture().collector().done_cells() == 4);
  CHECK(next.samples() == life.run.state().samples);
}

TEST_CASE("a run without results needs no store") {
  OneJob store(made_in_one_pass());
  Deferred life(store);
  life.run.commit();
  life.trace({0, 4});
  life.run.clear_buffer();
  life.run.commit();
  CHECK(life.opened == 0);
}

TEST_CASE("at a damaged entry, a run fails or traces the rest again") {
  OneJob store(made_in_one_pass());
  {
    RunLife first(store);
    first.trace({0, 3});
    first.commit();
  }
  const std::string entry = rows_of(store, only_job).back();
  std::string other_pass = entry;
  other_pass[4] = 9;
  for (const std::string& bad :
       {std::string(), std::string("rubbish"), entry.substr(0, entry.size() / 2), other_pass}) {
    CAPTURE(bad);
    OneJob damaged(made_in_one_pass());
    const std::vector<std::string> rows = rows_of(store, only_job);
    for (const std::string& sound : rows) damaged.append_rows(only_job, sound);
    damaged.append_rows(only_job, bad);
    damaged.append_rows(only_job, entry);
    damaged.commit();
    JobRun strict(damaged.record(), &damaged);
    strict.create_picture(SceneFacts(test::small_scene()));
    CHECK_THROWS_AS(strict.replay(JobRun::OnDamage::fail), DecodeError);
    CHECK(damaged.committed_rows(only_job).size() == rows.size() + 2);
    RunLife life(damaged);
    CHECK_FALSE(life.damage.empty());
    CHECK(life.picture().collector().done_cells() == 3);
    life.commit();
    CHECK(damaged.committed_rows(only_job).size() == rows.size());
    life.trace_all();
    CHECK(
        test::same_sums(life.picture().framebuffer(), test::made_framebuffer(made_in_one_pass())));
  }
}

TEST_CASE("a record with passes that differ from those of the log is damage") {
  OneJob store(made_in_passes());
  {
    RunLife first(store);
    for (int pass = 0; pass < 2; ++pass) {
      first.trace_missing();
      first.begin_pass();
    }
    first.commit();
  }
  JobRecord record = store.record();
  REQUIRE(record.passes.size() >= 2);
  record.passes = {20 * 12 * 299};
  store.put_job(record);
  store.commit();
  RunLife life(store);
  CHECK_FALSE(life.damage.empty());
  life.trace_all();
  CHECK(life.complete);
}

TEST_CASE("a run that meets a full disk saves and finishes everything later") {
  OneJob store(made_in_one_pass());
  RunLife life(store);
  life.trace_all();
  store.fill(true);
  CHECK_THROWS_AS(life.commit(), StorageFull);
  CHECK_THROWS_AS(life.finish(), StorageFull);
  CHECK(store.committed_rows(only_job).empty());
  CHECK_FALSE(store.has_picture(only_job));
  store.fill(false);
  life.finish();
  life.commit();
  store.crash();
  CHECK(store.has_picture(only_job));
  CHECK(store.committed_rows(only_job).empty());
  CHECK(store.record().state == JobState::done);
}

TEST_CASE("the file of a finished picture ends with the journal") {
  OneJob store(made_in_one_pass());
  RunLife life(store);
  life.record().reason = "paused";
  life.trace_all();
  life.finish();
  life.commit();
  store.crash();
  const JobRecord record = store.record();
  CHECK(record.state == JobState::done);
  CHECK(record.reason.empty());
  CHECK(nlohmann::json::parse(record.report).at("samples") == 40 * 12 * 50);
  const std::string file = store.picture(only_job).value();
  const std::uint64_t size = picture_size(40, 12, kept_detail(made_in_one_pass()));
  CHECK(file.substr(size) == life.picture().journal().bytes());
  CHECK_NOTHROW(picture_from_bytes(40, 12, file.substr(0, size)));
}

TEST_CASE("a faulty machine's results leave the picture, the log and later runs") {
  OneJob store(made_in_one_pass());
  {
    RunLife life(store);
    life.trace({0, 3}, faulty_tracer);
    life.trace({3, 5});
    const auto removed = life.retract({4, faulty_tracer, "w7"}, 1e9);
    REQUIRE(removed);
    CHECK(removed->cells == std::vector<CellRange>{{0, 3}});
    CHECK(life.record().flag == "worker 'w7' returned wrong bits: 3 cells were traced again");
    CHECK_FALSE(life.retract({5, faulty_tracer, "w7"}, 1e9));
    life.commit();
  }
  store.crash();
  CHECK(store.record().fault_findings == 5);
  RunLife next(store);
  CHECK(next.picture().collector().done_cells() == 2);
}

TEST_CASE("a run begins its picture again if a faulty machine influenced its passes") {
  OneJob store(made_in_passes());
  {
    RunLife life(store);
    life.trace({0, 1}, faulty_tracer);
    life.trace_missing();
    REQUIRE(life.begin_pass());
    life.trace({0, 1});
    life.commit();
  }
  const nlohmann::json fault_findings = {
      {{"number", 3}, {"machine", faulty_tracer}, {"worker", "w7"}}};
  store.put_note("workers", nlohmann::json{{"convictions", fault_findings}}.dump());
  RunLife life(store);
  CHECK(life.samples_before() > 0);
  life.retract_faulty(1e9);
  CHECK(life.samples_before() == 0);
  CHECK(life.samples() == 0);
  life.commit();
  store.crash();
  CHECK(store.record().passes.empty());
  CHECK(store.record().fault_findings == 3);
  CHECK(store.record().flag == "worker 'w7' returned wrong bits: the picture was started again");
  RunLife next(store);
  CHECK(next.damage.empty());
  CHECK(next.samples() == 0);
  next.retract_faulty(1e9);
  next.trace_all();
  CHECK(next.record().passes.size() >= 2);
}

TEST_CASE("a damaged note of workers is an error") {
  OneJob store(made_in_one_pass());
  RunLife life(store);
  CHECK_NOTHROW(life.retract_faulty(1e9));
  store.put_note("workers", "{");
  CHECK_THROWS_AS(life.retract_faulty(1e9), RunError);
}

TEST_CASE("a newer record does not replace the passes and fault findings of the run") {
  OneJob store(made_in_passes());
  RunLife life(store);
  JobRecord older = store.record();
  life.trace_missing();
  life.begin_pass();
  life.retract({4, faulty_tracer, "w7"}, 1e9);
  const auto passes = life.record().passes;
  older.priority = 90;
  older.passes = {};
  life.put(older);
  CHECK(life.record().priority == 90);
  CHECK(store.record().priority == 90);
  CHECK(store.record().passes == passes);
  CHECK(store.record().fault_findings == 4);
}

TEST_CASE("the finished share follows cells, samples or time") {
  OneJob store(made_in_one_pass());
  RunLife life(store);
  const std::uint64_t cells = life.picture().plan()->cells();
  life.trace({0, cells / 4});
  CHECK(share_done(made_in_one_pass(), life.state(), 0) ==
        doctest::Approx(static_cast<double>(cells / 4) / static_cast<double>(cells)));
  RunState state;
  state.samples = 30;
  CHECK(share_done(made_in_passes(), state, 100) == 0);
  state.expected_samples = 120;
  CHECK(share_done(made_in_passes(), state, 100) == 0.25);
  RenderSettings limited = made_in_passes();
  limited.time_limit = 10;
  CHECK(share_done(limited, state, 1) == 0.25);
  CHECK(share_done(limited, state, 5) == 0.5);
  CHECK(share_done(limited, state, 20) == 1);
}

}  // namespace parray
