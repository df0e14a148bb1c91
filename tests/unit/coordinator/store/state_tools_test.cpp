#include "coordinator/store/state_tools.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <random>
#include <thread>

#include "coordinator/store/database.h"
#include "tests/support/acknowledged.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

}  // namespace

TEST_CASE("--check refuses a served state and changes nothing") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    live(store, [] {});
    CHECK_THROWS_AS(repair_state(directory.path(), 0), StateInUse);
  }
  std::map<std::string, std::string> before;
  for (const auto& [name, size] : files_below(directory.path())) {
    before[name] = file_bytes(directory.path() / name);
  }
  CHECK(find_damage(directory.path()) == Strings{});
  CHECK(repair_state(directory.path(), 0) == Strings{});
  CHECK(files_below(directory.path()).size() == before.size());
  for (const auto& [name, bytes] : before) CHECK(file_bytes(directory.path() / name) == bytes);
  CHECK_THROWS_AS(find_damage(directory.path() / "jobs"), InputError);
  CHECK_THROWS_AS(find_damage(directory.path() / "nowhere"), InputError);
}

TEST_CASE("a repair without the last commits names every job whose log may have lost its end") {
  const TemporaryDirectory directory(in_memory());
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(damaged, directory.path() / "workshop");
  fs::resize_file(damaged / "parray.sqlite-wal", 0);
  const fs::path log = damaged / "jobs/6/rows";
  const std::string bytes = file_bytes(log);
  const std::size_t last = bytes.find("row " + std::string(300, 'r'));
  REQUIRE(last != std::string::npos);
  std::size_t size = last;
  do {  // the first entry ends somewhere before
    REQUIRE(size > 1);
    fs::resize_file(log, --size);
  } while (store::sound_bytes(log) != size);
  const Strings lines = repair_state(damaged, 1e9);
  CHECK(names(lines, 4));
  CHECK(names(lines, 6));
  check_all(damaged, acknowledged, lines);
}

TEST_CASE("a state whose copies were replaced by directories serves without a repair") {
  const TemporaryDirectory directory(in_memory());
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(damaged, directory.path() / "workshop");
  for (const char* name : {"jobs/2/job.json", "jobs/3/picture", "jobs/6/rows", "notes.json"}) {
    fs::remove(damaged / name);
    fs::create_directories(damaged / name / "inside");
  }
  Strings reports;
  {
    const DiskStore store(damaged);
    reports = store.reports();
  }
  CHECK(std::ranges::count(reports,
                           "jobs/2/job.json is a directory, not a file: moved to lost/0") == 1);
  CHECK(fs::is_regular_file(damaged / "jobs/2/job.json"));
  check_all(damaged, acknowledged, reports);
}

TEST_CASE("a backup of a busy state has every job that was acknowledged before") {
  const TemporaryDirectory directory(in_memory());
  const fs::path state = directory.path() / "state";
  std::mutex mutex;
  Acknowledged acknowledged;
  std::atomic<bool> stop = false;
  DiskStore store(state);
  submit(store, acknowledged, 1);
  std::jthread farm([&] {
    std::mt19937_64 random(7);
    for (JobId id = 2; !stop && id < 400; ++id) {
      Acknowledged fresh;
      submit(store, fresh, id);
      trace(store, fresh, id);
      if (id % 2 == 0) finish(store, fresh, id);
      const std::scoped_lock lock(mutex);
      acknowledged.rows.merge(fresh.rows);
      acknowledged.pictures.merge(fresh.pictures);
    }
  });
  for (int i = 0; i < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    Acknowledged before;
    {
      const std::scoped_lock lock(mutex);
      before = acknowledged;
    }
    const fs::path copy = directory.path() / ("copy" + std::to_string(i));
    CHECK(back_up_state(state, copy, 1e9) == Strings{});
    CHECK(find_damage(copy) == Strings{});
    DiskStore restored(copy);
    CHECK(restored.reports() == Strings{});
    for (const auto& [id, picture] : before.pictures) CHECK(restored.picture(id) == picture);
    for (const auto& [id, rows] : before.rows) CHECK(rows_of(restored, id) == rows);
  }
  stop = true;
  CHECK_THROWS_AS(back_up_state(state, directory.path() / "copy0", 1e9), InputError);
}

}  // namespace parray::test
