#include "coordinator/sqlite_store.h"

#include <doctest/doctest.h>
#include <sqlite3.h>

#include <filesystem>
#include <fstream>

#include "common/base/error.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

JobRecord record(JobId id) {
  JobRecord job;
  job.id = id;
  job.token = "token-" + std::to_string(id);
  job.name = "a scene, with \"quotes\"";
  job.priority = 70;
  job.settings = small_settings(small_scene());
  job.settings.seed = UINT64_MAX;
  job.precision_reason = "asked for";
  job.duplicates_removed = 5;
  job.load_seconds = 0.25;
  job.scene = "digest";
  job.life = 3;
  return job;
}

std::vector<std::string> blocks_of(Store& store, JobId job) {
  std::vector<std::string> blocks;
  store.each_block(job, [&](const std::string& bytes) { blocks.push_back(bytes); });
  return blocks;
}

void execute(const std::filesystem::path& directory, const char* sql) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open((directory / "parray.sqlite").c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, sql, nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

}  // namespace

TEST_CASE("what was committed is there after a restart, what was not is gone") {
  const TemporaryDirectory directory;
  {
    SqliteStore store(directory.path() / "deep" / "state");  // made if need be
    store.put_job(record(7));
    store.put_scene("digest", std::string("scene\0bytes", 11));
    store.put_block(7, 1, "first");
    store.put_block(7, (std::uint64_t{3} << 32) + 1, "second");
    store.commit();
    store.put_block(7, 2, "never committed");
    store.put_job(record(8));
  }
  SqliteStore store(directory.path() / "deep" / "state");
  const auto jobs = store.jobs();
  REQUIRE(jobs.size() == 1);
  const JobRecord expected = record(7);
  CHECK(jobs[0].id == 7);
  CHECK(jobs[0].token == expected.token);
  CHECK(jobs[0].name == expected.name);
  CHECK(jobs[0].priority == expected.priority);
  CHECK(jobs[0].settings == expected.settings);
  CHECK(jobs[0].duplicates_removed == expected.duplicates_removed);
  CHECK(jobs[0].load_seconds == expected.load_seconds);
  CHECK(jobs[0].life == expected.life);
  CHECK(jobs[0].state == JobState::queued);
  CHECK(store.scene("digest") == std::string("scene\0bytes", 11));
  CHECK(blocks_of(store, 7) == std::vector<std::string>{"first", "second"});
  CHECK_FALSE(store.picture(7).has_value());
}

TEST_CASE("a finished job keeps its picture and drops its blocks and its scene") {
  const TemporaryDirectory directory;
  SqliteStore store(directory.path());
  JobRecord job = record(1);
  store.put_job(job);
  store.put_scene("digest", "scene");
  store.put_block(1, 1, "block");
  store.commit();
  job.state = JobState::done;
  store.put_picture(1, "picture");
  store.put_job(job);
  store.drop_work(1);
  store.commit();
  CHECK(blocks_of(store, 1).empty());
  CHECK_FALSE(store.scene("digest").has_value());
  CHECK(store.picture(1) == "picture");
  store.drop_job(1);
  store.commit();
  CHECK(store.jobs().empty());
  CHECK_FALSE(store.picture(1).has_value());
}

TEST_CASE("a scene stays while another open job uses it") {
  const TemporaryDirectory directory;
  SqliteStore store(directory.path());
  store.put_scene("digest", "scene");
  store.put_job(record(1));
  store.put_job(record(2));
  JobRecord done = record(1);
  done.state = JobState::done;
  store.put_job(done);
  store.drop_work(1);
  CHECK(store.scene("digest") == "scene");
}

TEST_CASE("a second coordinator on the same state is refused") {
  const TemporaryDirectory directory;
  const SqliteStore store(directory.path());
  CHECK_THROWS_AS(SqliteStore{directory.path()}, InputError);
}

TEST_CASE("a state of a later version, a damaged record and a file that is none are told apart") {
  const TemporaryDirectory later;
  { const SqliteStore store(later.path()); }
  execute(later.path(), "PRAGMA user_version = 999");
  CHECK_THROWS_WITH_AS(SqliteStore{later.path()}, doctest::Contains("later version"), RunError);

  const TemporaryDirectory damaged;
  {
    SqliteStore store(damaged.path());
    store.put_job(record(1));
    store.commit();
  }
  execute(damaged.path(), "UPDATE jobs SET record = '{\"token\": 5}'");
  SqliteStore store(damaged.path());
  CHECK_THROWS_WITH_AS(store.jobs(), doctest::Contains("job 1 is damaged"), RunError);

  const TemporaryDirectory garbage;
  std::ofstream(garbage.path() / "parray.sqlite") << std::string(5000, 'x');
  CHECK_THROWS_AS(SqliteStore{garbage.path()}, RunError);
}

TEST_CASE("a directory that cannot be made is refused with its name") {
  CHECK_THROWS_WITH_AS(SqliteStore{"/dev/null/state"}, doctest::Contains("/dev/null/state"),
                       InputError);
}

}  // namespace parray::test
