// Which states a DiskStore opens, and which files it sets aside then.
#include <doctest/doctest.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "coordinator/store/disk_store.h"
#include "coordinator/store/state_tools.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

using Strings = std::vector<std::string>;

void run_sql(const std::filesystem::path& directory, const char* sql) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open((directory / "parray.sqlite").c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, sql, nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

}  // namespace

TEST_CASE("a second coordinator on the same state is refused") {
  const TemporaryDirectory directory;
  const DiskStore store(directory.path());
  CHECK_THROWS_WITH_AS(DiskStore{directory.path()}, doctest::Contains("another process"),
                       InputError);
}

TEST_CASE("a state of another version is refused with its number and stays as it is") {
  const TemporaryDirectory later;
  { const DiskStore store(later.path()); }
  run_sql(later.path(), "PRAGMA user_version = 999");
  CHECK_THROWS_WITH_AS(DiskStore{later.path()}, doctest::Contains("is of version 999"), InputError);

  const TemporaryDirectory earlier;
  write_bytes(earlier.path() / "parray.sqlite", "");
  run_sql(earlier.path(), "CREATE TABLE blocks (job INTEGER); PRAGMA user_version = 2");
  CHECK_THROWS_WITH_AS(DiskStore{earlier.path()}, doctest::Contains("is of version 2"), InputError);
  run_sql(earlier.path(), "INSERT INTO blocks VALUES (1)");
  CHECK_THROWS_WITH_AS(find_damage(earlier.path()), doctest::Contains("is of version 2"),
                       InputError);
}

TEST_CASE("a damaged record and a file that is no database are told apart") {
  for (const char* record : {"{\"token\": 5}", "", "[", "{}"}) {
    const TemporaryDirectory damaged;
    {
      DiskStore store(damaged.path());
      store.put_job(stored_job(1));
      store.commit();
    }
    run_sql(damaged.path(), ("UPDATE jobs SET record = '" + std::string(record) + "'").c_str());
    CHECK_THROWS_WITH_AS(DiskStore{damaged.path()}, doctest::Contains("of job 1"), StateDamaged);
  }

  const TemporaryDirectory garbage;
  write_bytes(garbage.path() / "parray.sqlite", std::string(5000, 'x'));
  CHECK_THROWS_AS(DiskStore{garbage.path()}, RunError);
}

TEST_CASE("an unknown job state is a damaged record") {
  std::string text = record_to_json(stored_job(1, JobState::cancelled));
  CHECK(record_from_json(1, text).state == JobState::cancelled);
  const std::size_t at = text.find("\"state\":5");
  REQUIRE(at != std::string::npos);
  CHECK_THROWS_AS(record_from_json(1, text.replace(at, 9, "\"state\":6")), RunError);
  CHECK_THROWS_AS(record_from_json(1, text.replace(at, 9, "\"state\":-1")), RunError);
}

TEST_CASE("a number of a wrong type or range is a damaged record") {
  const JobRecord job = stored_job(1, JobState::running);
  for (const char* key : {"priority", "tile", "duplicates_removed", "scene_bytes", "max_failures",
                          "convictions", "state"}) {
    for (const char* value : {"-1", "1.5", "1e300", "\"1\"", "[1]"}) {
      auto map = nlohmann::json::parse(record_to_json(job));
      map[key] = nlohmann::json::parse(value);
      CAPTURE(map.dump());
      CHECK_THROWS_AS(record_from_json(1, map.dump()), RunError);
    }
  }
}

TEST_CASE("an invalid share is a damaged record") {
  JobRecord job = stored_job(1, JobState::running);
  job.share = 2.5;
  CHECK(record_from_json(1, record_to_json(job)).share == 2.5);
  for (const double share : {0.0, -1.0, 1e300}) {
    job.share = share;
    CHECK_THROWS_AS(record_from_json(1, record_to_json(job)), RunError);
  }
}

TEST_CASE("an invalid pass is a damaged record") {
  JobRecord job = stored_job(1, JobState::running);
  job.passes = {1000};
  CHECK(record_from_json(1, record_to_json(job)).passes == job.passes);
  for (const std::uint64_t samples : {std::uint64_t{0}, UINT64_MAX}) {
    job.passes = {1000, samples};
    CHECK_THROWS_AS(record_from_json(1, record_to_json(job)), RunError);
  }
}

TEST_CASE("a directory that cannot be made is refused with its name") {
  CHECK_THROWS_WITH_AS(DiskStore{"/dev/null/state"}, doctest::Contains("/dev/null/state"),
                       InputError);
}

TEST_CASE("files that no record names move to lost/, and foreign files stay") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1));
    store.put_scene(digest('a'), "scene");
    store.append_rows(1, "row");
    store.commit();
  }
  const Strings kept = bulk_files(directory.path());
  for (const char* job : {"1", "2", "33"}) {
    const auto place = directory.path() / "jobs" / job;
    std::filesystem::create_directories(place);
    for (const char* name : {"rows.1", "picture", "picture.2", "picture.partial"}) {
      write_bytes(place / name, "left");
    }
  }
  std::filesystem::create_directories(directory.path() / "jobs" / "4");
  write_bytes(directory.path() / "scenes" / digest('b'), "left");
  write_bytes(directory.path() / "scenes" / (digest('c') + ".partial"), "left");
  {
    DiskStore store(directory.path());
    CHECK(rows_of(store, 1) == Strings{"row"});
    CHECK(store.reports().size() == 10);
    CHECK(store.reports()[1] == "jobs/1/picture is named by no record: moved to lost/0");
    CHECK(store.usage().total == 5 + 16 + 3 + 10 * 4);
    store.tidy(1);
    CHECK(store.usage().total == 5 + 16 + 3 + 10 * 4);
  }
  CHECK(bulk_files(directory.path()) == kept);
  CHECK(file_bytes(directory.path() / "lost" / "0" / "jobs" / "33" / "picture.2") == "left");
  CHECK_FALSE(std::filesystem::exists(directory.path() / "jobs" / "2"));
  CHECK_FALSE(std::filesystem::exists(directory.path() / "jobs" / "4"));

  const Strings foreign = {"jobs/1/notes", "jobs/mine/rows", "picture", "scenes/README"};
  for (const std::string& name : foreign) {
    std::filesystem::create_directories((directory.path() / name).parent_path());
    write_bytes(directory.path() / name, "somebody else's");
  }
  { const DiskStore store(directory.path()); }
  for (const std::string& name : foreign) CHECK(std::filesystem::exists(directory.path() / name));
}

TEST_CASE("files in lost/ are removed after the given uptime") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_note(uptime_note, "1000");
    store.put_job(stored_job(1));
    store.commit();
  }
  write_bytes(directory.path() / "jobs" / "1" / "picture", "left");
  DiskStore store(directory.path());
  const auto lost = directory.path() / "lost" / "1000" / "jobs" / "1" / "picture";
  CHECK(std::filesystem::exists(lost));
  store.put_note(uptime_note, "1060");
  store.tidy(60);
  CHECK(std::filesystem::exists(lost));
  store.put_note(uptime_note, "1061");
  store.tidy(60);
  CHECK_FALSE(std::filesystem::exists(lost));
  CHECK(store.usage().total == 0);
}

}  // namespace parray::test
