// A state of version 1, in which everything was in the database, becomes one of today's.
#include <doctest/doctest.h>
#include <sqlite3.h>

#include <stdexcept>

#include "common/scene/settings.h"
#include "tests/support/faulty_disk.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* settings_of_version_1 =
    R"({"accelerator":"bvh","height":13,"isa":"auto","max_depth":8,"precision":"f32",)"
    R"("row_order":"interleaved","sampler":"sobol","samples_per_pixel":6,)"
    R"("schedule":"weighted","seed":18446744073709551615,"width":20})";

/// As version 1 wrote it: `state` 0 queued, 1 running, 3 done, 4 failed, 5 cancelled.
std::string record_of_version_1(int id, int state) {
  return R"({"duplicates_removed":0,"life":2,"load_seconds":0.5,"name":"job )" +
         std::to_string(id) + R"(","passes":[],"precision_reason":"","priority":50,"reason":")" +
         (state == 4 ? "it failed" : "") + R"(","report":"","scene":")" + digest('a') +
         R"(","settings":)" + settings_of_version_1 + R"(,"state":)" + std::to_string(state) +
         R"(,"token":"t"})";
}

/// A directory with jobs 1 (done), 2 (queued), 3 (failed), 4 (running).
void make_version_1(const fs::path& directory, std::size_t picture_bytes) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open((directory / "parray.sqlite").c_str(), &db) == SQLITE_OK);
  const auto run = [&](const std::string& sql) {
    REQUIRE(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  };
  run("PRAGMA journal_mode = WAL");
  run("CREATE TABLE jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
      "  open INTEGER NOT NULL, record TEXT NOT NULL);"
      "CREATE TABLE scenes (digest TEXT PRIMARY KEY, bytes BLOB NOT NULL);"
      "CREATE TABLE blocks (job INTEGER NOT NULL, epoch INTEGER NOT NULL,"
      "  bytes BLOB NOT NULL, PRIMARY KEY (job, epoch));"
      "CREATE TABLE pictures (job INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"
      "PRAGMA user_version = 1");
  const int states[] = {3, 0, 4, 1};
  for (int id = 1; id <= 4; ++id) {
    const int state = states[id - 1];
    run("INSERT INTO jobs VALUES (" + std::to_string(id) + ", '" + digest('a') + "', " +
        (state < 2 ? "1" : "0") + ", '" + record_of_version_1(id, state) + "')");
  }
  run("INSERT INTO scenes VALUES ('" + digest('a') + "', zeroblob(100000))");
  run("INSERT INTO blocks VALUES (2, 1, zeroblob(100000)), (4, 4294967297, x'00ff')");
  run("INSERT INTO pictures VALUES (1, CAST('picture' AS BLOB) || zeroblob(" +
      std::to_string(picture_bytes - 7) + "))");
  sqlite3_close(db);
}

std::string picture_of(std::size_t bytes) { return "picture" + std::string(bytes - 7, '\0'); }

void check_converted(const fs::path& directory, std::size_t picture_bytes) {
  DiskStore store(directory);
  const auto jobs = store.jobs();
  REQUIRE(jobs.size() == 4);
  CHECK(jobs[0].state == JobState::done);
  CHECK(jobs[0].name == "job 1");
  CHECK(jobs[0].settings->width == 20);
  CHECK(jobs[1].state == JobState::cancelled);
  CHECK(jobs[1].reason == "kept by an earlier version: submit it again");
  CHECK(jobs[2].state == JobState::failed);
  CHECK(jobs[2].reason == "it failed");
  CHECK(jobs[3].state == JobState::cancelled);
  CHECK(store.picture(1) == picture_of(picture_bytes));
  CHECK(rows_of(store, 2).empty());
  CHECK_FALSE(store.scene(digest('a')).has_value());
  CHECK(bulk_files(directory) == std::vector<std::string>{"jobs/1/picture"});
  CHECK(files_below(directory)["parray.sqlite"] < 60'000);
}

}  // namespace

TEST_CASE("a state of version 1 keeps its pictures and cancels what was unfinished") {
  const TemporaryDirectory directory;
  constexpr std::size_t picture_bytes = 1'000'000;
  make_version_1(directory.path(), picture_bytes);
  check_converted(directory.path(), picture_bytes);
  check_converted(directory.path(), picture_bytes);  // and stays so
  DiskStore store(directory.path());
  store.drop_job(1);
  store.put_job(stored_job(5));
  store.append_rows(5, "row");
  store.commit();
  CHECK(rows_of(store, 5).size() == 1);
}

TEST_CASE("a conversion that stops at any step, or finds no room, can be done again") {
  const TemporaryDirectory directory(in_memory());
  const fs::path original = directory.path() / "original";
  const fs::path state = directory.path() / "state";
  fs::create_directory(original);
  make_version_1(original, 5000);
  for (int last = 0;; ++last) {
    CAPTURE(last);
    copy_state(original, state);
    FaultyDisk disk;
    int steps = 0;
    disk.before = [&] {
      if (steps++ == last) {
        throw std::logic_error("the plug is pulled");
      }
    };
    bool stopped = false;
    try {
      const DiskStore store(state, disk);
    } catch (const std::logic_error&) {
      stopped = true;
    }
    check_converted(state, 5000);
    if (!stopped) {
      CHECK(last > 4);
      break;
    }
  }
  copy_state(original, state);
  FaultyDisk disk;
  disk.room = 3000;
  CHECK(message_of<InputError>([&] { const DiskStore store(state, disk); }).find("make room") !=
        std::string::npos);
  check_converted(state, 5000);
}

TEST_CASE("a record of version 1 that is damaged is named") {
  const TemporaryDirectory directory;
  make_version_1(directory.path(), 100);
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open((directory.path() / "parray.sqlite").c_str(), &db) == SQLITE_OK);
  sqlite3_exec(db, "UPDATE jobs SET record = '[' WHERE id = 3", nullptr, nullptr, nullptr);
  sqlite3_close(db);
  CHECK(message_of<RunError>([&] {
          const DiskStore store(directory.path());
        }).find("job 3 is damaged") != std::string::npos);
}

}  // namespace parray::test
