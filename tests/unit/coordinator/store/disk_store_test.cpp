#include "coordinator/store/disk_store.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "common/base/error.h"
#include "coordinator/store/state_tools.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

using Strings = std::vector<std::string>;

std::uint64_t total_bytes(const std::filesystem::path& directory) {
  std::uint64_t total = 0;
  for (const auto& [name, size] : files_below(directory)) total += size;
  return total;
}

}  // namespace

TEST_CASE("a restart keeps committed changes and forgets others") {
  const TemporaryDirectory directory;
  const auto state = directory.path() / "deep" / "state";  // the store creates it
  {
    DiskStore store(state);
    store.put_job(stored_job(7));
    store.put_scene(digest('a'), std::string_view("scene\0bytes", 11));
    store.append_rows(7, "first");
    store.append_rows(7, "");
    store.append_rows(7, std::string("\0second", 7));
    store.commit();
    store.append_rows(7, "never committed");
    store.put_job(stored_job(8));
    store.put_scene(digest('b'), "never committed");
    put_picture(store, 7, "never committed");
  }
  DiskStore store(state);
  const auto jobs = store.jobs();
  REQUIRE(jobs.size() == 1);
  const JobRecord expected = stored_job(7);
  CHECK(jobs[0].id == 7);
  CHECK(jobs[0].token == expected.token);
  CHECK(jobs[0].name == expected.name);
  CHECK(jobs[0].priority == expected.priority);
  CHECK(jobs[0].settings == expected.settings);
  CHECK(jobs[0].duplicates_removed == expected.duplicates_removed);
  CHECK(jobs[0].load_seconds == expected.load_seconds);
  CHECK(jobs[0].scene == expected.scene);
  CHECK(jobs[0].state == JobState::queued);
  CHECK(store.scene(digest('a')) == std::string("scene\0bytes", 11));
  CHECK_FALSE(store.scene(digest('b')).has_value());
  CHECK(rows_of(store, 7) == Strings{"first", "", std::string("\0second", 7)});
  CHECK_FALSE(store.picture(7).has_value());
  CHECK(store.picture_bytes(7) == 0);
  CHECK(bulk_files(state) == Strings{"jobs/7/rows", "scenes/" + digest('a')});
}

TEST_CASE("new data can be read before the commit") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  store.put_job(stored_job(1));
  store.append_rows(1, "a");
  store.put_scene(digest('a'), "scene");
  put_picture(store, 1, "picture");
  CHECK(store.jobs().size() == 1);
  CHECK(rows_of(store, 1) == Strings{"a"});
  CHECK(store.scene(digest('a')) == "scene");
  CHECK(store.picture(1) == "picture");
  store.commit();
  store.append_rows(1, "b");
  CHECK(rows_of(store, 1) == Strings{"a", "b"});
  store.drop_job(1);
  CHECK(store.jobs().empty());
  CHECK(rows_of(store, 1).empty());
  CHECK_FALSE(store.picture(1).has_value());
}

TEST_CASE("a picture consists of its pieces, possibly none") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1, JobState::done));
    store.put_job(stored_job(2, JobState::done));
    const std::vector<std::string_view> pieces = {"float", "", "samples", "widths"};
    store.put_picture(1, pieces);
    store.put_picture(2, {});
    store.commit();
  }
  DiskStore store(directory.path());
  CHECK(store.picture(1) == "floatsampleswidths");
  CHECK(store.picture_bytes(1) == 18);
  CHECK(store.picture(2) == "");
}

TEST_CASE("a finished job keeps its picture and drops its results and its scene") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  store.put_job(stored_job(1));
  store.put_scene(digest('a'), "scene");
  store.append_rows(1, "row");
  store.commit();
  put_picture(store, 1, "picture");
  store.put_job(stored_job(1, JobState::done));
  store.drop_work(1);
  store.commit();
  CHECK(rows_of(store, 1).empty());
  CHECK_FALSE(store.scene(digest('a')).has_value());
  CHECK(store.picture(1) == "picture");
  CHECK(bulk_files(directory.path()) == Strings{"jobs/1/picture"});
  store.drop_job(1);
  store.commit();
  CHECK(store.jobs().empty());
  CHECK_FALSE(store.picture(1).has_value());
  CHECK(bulk_files(directory.path()).empty());
  CHECK_FALSE(std::filesystem::exists(directory.path() / "jobs" / "1"));
}

TEST_CASE("a finished job whose pictures need the scene keeps it, also after a new start") {
  const TemporaryDirectory directory;
  for (const bool denoise : {true, false}) {
    DiskStore store(directory.path());
    JobRecord job = stored_job(1, JobState::done);
    job.denoise = denoise;
    job.drawing = denoise ? "" : "{}";
    store.put_job(job);
    store.put_scene(digest('a'), "scene");
    store.drop_work(1);
    store.commit();
    CHECK(store.scene(digest('a')) == "scene");
  }
  DiskStore store(directory.path());
  CHECK(store.scene(digest('a')) == "scene");
  store.drop_job(1);
  store.commit();
  CHECK_FALSE(store.scene(digest('a')).has_value());
}

TEST_CASE("a record of a version without denoising and drawings is read") {
  JobRecord job = stored_job(1);
  job.denoise = true;
  job.drawing = "{}";
  auto map = nlohmann::json::parse(record_to_json(job));
  CHECK(record_from_json(1, map.dump()).denoise);
  CHECK(record_from_json(1, map.dump()).drawing == "{}");
  map.erase("denoise");
  map.erase("drawing");
  CHECK_FALSE(record_from_json(1, map.dump()).keeps_scene());
}

TEST_CASE("a scene stays while an unfinished or failed job uses it") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  store.put_scene(digest('a'), "scene");
  store.put_job(stored_job(1));
  store.put_job(stored_job(2, JobState::paused));
  store.commit();
  store.put_job(stored_job(1, JobState::done));
  store.drop_work(1);
  store.commit();
  CHECK(store.scene(digest('a')) == "scene");
  store.put_job(stored_job(2, JobState::failed));
  store.commit();
  CHECK(store.scene(digest('a')) == "scene");
  store.drop_job(2);
  store.commit();
  CHECK_FALSE(store.scene(digest('a')).has_value());
}

TEST_CASE("notes are stored by name, and usage() counts a shared scene once") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_note("workers", "some");
    store.put_note("workers", "others");
    store.put_scene(digest('a'), "scene");
    store.put_job(stored_job(1));
    store.put_job(stored_job(2));
    store.append_rows(2, "rows");
    CHECK(store.note("workers") == "others");
    store.commit();
  }
  DiskStore store(directory.path());
  CHECK(store.note("workers") == "others");
  CHECK(store.note("nothing").empty());
  const Store::Usage usage = store.usage();
  CHECK(usage.jobs.at(1) == 5);
  CHECK(usage.jobs.at(2) == 5 + 16 + 4);
  CHECK(usage.total == 5 + 16 + 4);
}

TEST_CASE("dropped results are gone, and later entries form a new log") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1));
    store.append_rows(1, "early");
    store.drop_rows(1);
    store.append_rows(1, "one");
    store.commit();
    store.drop_rows(1);
    store.append_rows(1, "two");
    CHECK(rows_of(store, 1) == Strings{"two"});
  }
  {
    DiskStore store(directory.path());
    CHECK(rows_of(store, 1) == Strings{"one"});  // neither drop nor append was committed
    store.drop_rows(1);
    store.append_rows(1, "three");
    store.commit();
    store.append_rows(1, "four");
    store.commit();
  }
  CHECK(bulk_files(directory.path()).size() == 1);
  DiskStore store(directory.path());
  CHECK(rows_of(store, 1) == Strings{"three", "four"});
  store.drop_rows(1);
  store.commit();
  CHECK(rows_of(store, 1).empty());
  CHECK(bulk_files(directory.path()).empty());
}

TEST_CASE("keep_rows() keeps the first entries, and later entries follow them") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1));
    for (const char* row : {"one", "two", "damaged", "four"}) store.append_rows(1, row);
    store.commit();
    store.keep_rows(1, 2);
    store.append_rows(1, "3");
    CHECK(rows_of(store, 1) == Strings{"one", "two", "3"});
    store.commit();
  }
  DiskStore store(directory.path());
  CHECK(store.reports() == Strings{});
  CHECK(rows_of(store, 1) == Strings{"one", "two", "3"});
  store.keep_rows(1, 0);
  store.commit();
  CHECK(rows_of(store, 1).empty());
}

TEST_CASE("a picture is replaced whole, or not at all") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1, JobState::done));
    put_picture(store, 1, "old");
    store.commit();
    put_picture(store, 1, "never committed");
    CHECK(store.picture(1) == "never committed");
  }
  DiskStore store(directory.path());
  CHECK(store.picture(1) == "old");
  put_picture(store, 1, "newer");
  put_picture(store, 1, "newest");
  store.commit();
  CHECK(store.picture(1) == "newest");
  CHECK(bulk_files(directory.path()).size() == 1);
}

TEST_CASE("only a digest becomes the name of a scene") {
  const TemporaryDirectory directory;
  DiskStore store(directory.path());
  for (const std::string& name :
       {std::string("../jobs/1/picture"), std::string(), std::string(63, 'a'), std::string(65, 'a'),
        std::string(64, 'A'), std::string(64, '/'), std::string(64, '.'),
        "../" + std::string(61, 'a'), std::string(63, 'a') + '\0'}) {
    CHECK_THROWS_AS(store.put_scene(name, "scene"), std::logic_error);
    CHECK_FALSE(store.scene(name).has_value());
  }
  CHECK(bulk_files(directory.path()).empty());
}

TEST_CASE("a commit frees the room of a dropped job, also in the database") {
  const TemporaryDirectory directory(in_memory());
  DiskStore store(directory.path());
  store.commit();
  const auto put_all = [&] {
    for (JobId id = 1; id <= 200; ++id) {
      JobRecord job = stored_job(id, JobState::done);
      job.report = std::string(50'000, 'r');
      store.put_job(job);
      put_picture(store, id, std::string(10'000, 'p'));
    }
    store.commit();
  };
  put_all();
  CHECK(total_bytes(directory.path()) > 12'000'000);
  for (JobId id = 1; id <= 200; ++id) store.drop_job(id);
  store.commit();
  CHECK(bulk_files(directory.path()).empty());
  store.put_job(stored_job(1));  // the write empties the database's log
  store.commit();
  CHECK(files_below(directory.path())["parray.sqlite"] < 100'000);
  CHECK(files_below(directory.path())["parray.sqlite-wal"] <= 4'194'304);
}

TEST_CASE("any sequence of puts, drops, commits and crashes agrees with a model") {
  using Dice = std::mt19937_64;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const auto roll = [&](std::uint64_t sides) { return dice() % sides; };
    const TemporaryDirectory directory(in_memory());
    auto store = std::make_unique<DiskStore>(directory.path());
    CrashStore model(0, seed);
    const auto both = [&](const auto& action) {
      action(static_cast<Store&>(*store));
      action(static_cast<Store&>(model));
    };
    for (int step = 0; step < 150; ++step) {
      const JobId id = 1 + roll(4);
      const std::string bytes(roll(300), static_cast<char>('a' + roll(26)));
      const auto scene = static_cast<char>('a' + roll(3));
      const auto state = static_cast<JobState>(roll(6));
      switch (roll(12)) {
        case 0:
        case 1: both([&](Store& s) { s.put_job(stored_job(id, state, scene)); }); break;
        case 2: both([&](Store& s) { s.put_scene(digest(scene), "scene"); }); break;
        case 3:
        case 4:
        case 5: both([&](Store& s) { s.append_rows(id, bytes); }); break;
        case 6: both([&](Store& s) { s.drop_rows(id); }); break;
        case 7: both([&](Store& s) { put_picture(s, id, bytes); }); break;
        case 8: both([&](Store& s) { s.drop_work(id); }); break;
        case 9: both([&](Store& s) { s.drop_job(id); }); break;
        case 10: both([&](Store& s) { s.commit(); }); break;
        default:
          store.reset();
          store = std::make_unique<DiskStore>(directory.path());
          model.crash();
      }
      REQUIRE(stored_state(*store) == stored_state(model));
    }
  }
}

TEST_CASE("long: a picture larger than the limit of a database" * doctest::skip()) {
  const TemporaryDirectory directory;
  const std::string piece(1'000'000, '\0');
  const std::vector<std::string_view> pieces(1100, piece);
  {
    DiskStore store(directory.path());
    store.put_job(stored_job(1, JobState::done));
    store.put_picture(1, pieces);
    store.commit();
  }
  DiskStore store(directory.path());
  CHECK(store.picture_bytes(1) == 1'100'000'000);
  const auto picture = store.picture(1);
  REQUIRE(picture.has_value());
  CHECK(picture->size() == 1'100'000'000);
  CHECK(picture->find_first_not_of('\0') == std::string::npos);
  store.drop_job(1);
  store.commit();
  CHECK(total_bytes(directory.path()) < 1'000'000);
}

}  // namespace parray::test
