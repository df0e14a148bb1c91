// Tests that a DiskStore survives a failure of the process, the machine or the disk at any moment.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include "coordinator/store/state_tools.h"
#include "tests/support/faulty_disk.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_changes.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

/// Fills the disk after every `step` bytes of a commit.
void check_full_disks(std::uint64_t step) {
  const TemporaryDirectory directory(in_memory());
  StoredState before;
  StoredState after;
  std::uint64_t whole = 1;
  for (std::uint64_t room = 0; room <= whole; room += room == 0 ? 1 : step) {
    CAPTURE(room);
    const fs::path state = directory.path() / "state";
    const fs::path crashed = directory.path() / "crashed";
    fs::remove_all(state);
    FaultyDisk disk;
    DiskStore store(state, disk);
    put_first(store);
    if (room == 0) {  // the first run only measures
      before = stored_state(store);
      constexpr std::uint64_t plenty = 1'000'000;
      disk.room = plenty;
      put_second(store);
      store.commit();
      after = stored_state(store);
      whole = plenty - disk.room;
      REQUIRE(whole > 50);
      continue;
    }
    disk.room = room - 1;
    const auto message = message_of<StorageFull>([&] {
      put_second(store);
      store.commit();
    });
    CHECK(message.starts_with(state.string() + ": "));
    CHECK(message.find('\n') == std::string::npos);
    copy_state(state, crashed);
    const StoredState left = stored_state(crashed);
    for (const JobId id : {JobId{1}, JobId{2}}) {  // all changes of a job, or none
      const StoredState& whole_job = left.records.at(id) == before.records.at(id) ? before : after;
      CHECK(left.rows.at(id).size() <= after.rows.at(id).size());
      CHECK(left.rows.at(id).size() >= before.rows.at(id).size());
      if (id == 1) CHECK(left.rows.at(id) == whole_job.rows.at(id));
    }
    disk.room = FaultyDisk::endless;
    store.commit();  // once more, with room
    CHECK(rows_of(store, 1) == after.rows.at(1));
    put_picture(store, 2, "picture 2, again");
    store.put_scene(digest('c'), "scene c");
    store.put_job(stored_job(3, JobState::queued, 'c'));
    if (rows_of(store, 3).empty()) store.append_rows(3, "row of 3");
    store.commit();
    CHECK(stored_state(store) == after);
    copy_state(state, crashed);
    CHECK(stored_state(crashed) == after);
    CHECK(bulk_files(crashed).size() == 5);
  }
}

}  // namespace

TEST_CASE("an append that is cut at any byte leaves exactly the committed results") {
  const TemporaryDirectory directory(in_memory());
  const fs::path before = directory.path() / "before";
  const fs::path crashed = directory.path() / "crashed";
  const fs::path rows = fs::path("jobs") / "1" / "rows";
  std::string longer;
  {
    DiskStore store(before);
    put_first(store);
  }
  copy_state(before, crashed);
  {
    DiskStore store(crashed);
    store.append_rows(1, "row 3");
    store.append_rows(1, std::string(40, 'x'));
    store.commit();
    longer = file_bytes(crashed / rows);
  }
  const std::size_t committed = file_bytes(before / rows).size();
  REQUIRE(longer.size() == committed + 16 + 5 + 16 + 40);
  for (std::size_t size = committed; size <= longer.size(); ++size) {
    CAPTURE(size);
    copy_state(before, crashed);
    write_bytes(crashed / rows, longer.substr(0, size));
    DiskStore store(crashed);
    CHECK(fs::file_size(crashed / rows) == committed);
    REQUIRE(rows_of(store, 1) == Strings{"row 1", "row 2"});
    store.append_rows(1, "again");
    store.commit();
    REQUIRE(rows_of(store, 1) == Strings{"row 1", "row 2", "again"});
  }
}

TEST_CASE("committed results that are cut or changed anywhere are damage of their own job only") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    put_first(store);
    store.put_job(stored_job(4));
    store.append_rows(4, "row of 4");
    store.commit();
  }
  const fs::path rows = directory.path() / "jobs" / "1" / "rows";
  const std::string whole = file_bytes(rows);
  const auto check_damaged = [&] {
    DiskStore store(directory.path());
    const auto message = message_of<RunError>([&] { rows_of(store, 1); });
    CHECK(message.find("jobs/1/rows are damaged") != std::string::npos);
    CHECK(rows_of(store, 4) == Strings{"row of 4"});
    CHECK(store.jobs().size() == 3);
  };
  for (std::size_t at = 0; at < whole.size(); ++at) {
    CAPTURE(at);
    write_bytes(rows, whole.substr(0, at));
    check_damaged();
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    write_bytes(rows, changed);
    check_damaged();
  }
  write_bytes(rows, std::string(whole.size(), '\0'));  // as a file system may leave it
  check_damaged();
  fs::remove(rows);
  check_damaged();
}

TEST_CASE("a damaged picture or scene is recognised") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    put_first(store);
  }
  for (const std::string& name : {std::string("jobs/2/picture"), "scenes/" + digest('a')}) {
    const fs::path file = directory.path() / name;
    const std::string whole = file_bytes(file);
    const auto check_damaged = [&] {
      DiskStore store(directory.path());
      const auto message = message_of<RunError>([&] {
        store.picture(2);
        store.scene(digest('a'));
      });
      CHECK_MESSAGE(message.find(file.string() + " is damaged") == 0, message);
    };
    write_bytes(file, whole.substr(1));
    check_damaged();
    write_bytes(file, whole + "x");
    check_damaged();
    write_bytes(file, "P" + whole.substr(1, whole.size() - 2) + "\1");
    check_damaged();
    fs::remove(file);
    check_damaged();
    fs::create_directories(file.parent_path());  // the store removed the empty directory
    write_bytes(file, whole);
  }
}

TEST_CASE("a process killed at any step of a commit leaves the state before it or after it") {
  const TemporaryDirectory directory(in_memory());
  const fs::path state = directory.path() / "state";
  const fs::path crashed = directory.path() / "crashed";
  FaultyDisk disk;
  DiskStore store(state, disk);
  put_first(store);
  const StoredState before = stored_state(store);
  std::vector<StoredState> left;
  disk.before = [&] {
    copy_state(state, crashed);
    CHECK(find_damage(crashed) == Strings{});
    left.push_back(stored_state(crashed));
    CHECK(bulk_files(crashed).size() == (left.back() == before ? 3 : 5));
  };
  put_second(store);
  store.commit();
  const StoredState after = stored_state(store);
  CHECK(after.rows.at(1).size() == 3);
  const auto first_after = std::find(left.begin(), left.end(), after);
  CHECK(std::all_of(left.begin(), first_after, [&](const auto& s) { return s == before; }));
  CHECK(std::all_of(first_after, left.end(), [&](const auto& s) { return s == after; }));
  CHECK(first_after - left.begin() > 10);
  CHECK(left.end() - first_after > 2);
  copy_state(state, crashed);
  CHECK(stored_state(crashed) == after);
}

TEST_CASE(
    "a disk that fills up at any byte loses nothing, and stores everything once there is room") {
  check_full_disks(17);
}

TEST_CASE("long: a disk that fills up at each byte loses nothing" * doctest::skip()) {
  check_full_disks(1);
}

TEST_CASE("data lost by a failed sync is written again") {
  const TemporaryDirectory directory;
  FaultyDisk disk;
  {
    DiskStore store(directory.path(), disk);
    put_first(store);
    store.append_rows(1, "row 3");
    disk.failing_syncs = 2;
    CHECK_THROWS_AS(store.commit(), StorageFull);
    store.append_rows(1, "row 4");
    CHECK_THROWS_AS(store.commit(), StorageFull);
    store.append_rows(1, "row 5");
    store.commit();
    disk.failing_syncs = 1;
    CHECK_THROWS_AS(put_picture(store, 2, "new"), StorageFull);
    CHECK(store.picture(2) == "picture 2");
    disk.failing_renames = 1;
    CHECK_THROWS_AS(put_picture(store, 2, "new"), StorageFull);
    CHECK(store.picture(2) == "picture 2");
    put_picture(store, 2, "new");
    store.commit();
  }
  DiskStore store(directory.path());
  CHECK(rows_of(store, 1) == Strings{"row 1", "row 2", "row 3", "row 4", "row 5"});
  CHECK(store.picture(2) == "new");
  CHECK(bulk_files(directory.path()).size() == 3);
}

TEST_CASE("a commit of many jobs syncs once, and data lost by a failed sync is written again") {
  const TemporaryDirectory directory;
  constexpr JobId jobs = 100;
  FaultyDisk disk;
  {
    DiskStore store(directory.path(), disk);
    put_first(store);
    const auto put_jobs = [&](JobState state) {
      for (JobId id = 3; id < 3 + jobs; ++id) {
        const char scene = static_cast<char>('0' + id % 10);
        store.put_scene(digest(scene), std::string("scene ") + scene);
        store.put_job(stored_job(id, state, scene));
      }
    };
    disk.file_syncs = 0;
    put_jobs(JobState::queued);
    disk.failing_syncs = 1;
    CHECK_THROWS_AS(store.commit(), StorageFull);
    store.commit();
    CHECK(disk.file_syncs == 0);
    CHECK(disk.file_system_syncs == 2);
    put_jobs(JobState::running);
    disk.failing_syncs = 1;
    CHECK_THROWS_AS(store.commit(), StorageFull);
    store.commit();
    CHECK(disk.file_system_syncs == 4);
  }
  CHECK(find_damage(directory.path()) == Strings{});
  DiskStore store(directory.path());
  REQUIRE(store.jobs().size() == jobs + 2);
  CHECK(store.jobs().back().state == JobState::running);
  for (char scene = '0'; scene <= '9'; ++scene) {
    CHECK(store.scene(digest(scene)) == std::string("scene ") + scene);
  }
}

TEST_CASE("a process killed while many jobs are committed leaves all of them or none") {
  const TemporaryDirectory directory(in_memory());
  const fs::path state = directory.path() / "state";
  const fs::path crashed = directory.path() / "crashed";
  constexpr JobId jobs = 30;
  FaultyDisk disk;
  DiskStore store(state, disk);
  put_first(store);
  std::vector<std::size_t> left;
  disk.before = [&] {
    copy_state(state, crashed);
    CHECK(find_damage(crashed) == Strings{});
    left.push_back(DiskStore(crashed).jobs().size());
  };
  for (JobId id = 3; id < 3 + jobs; ++id) store.put_job(stored_job(id));
  store.commit();
  const auto first_after = std::ranges::find(left, jobs + 2);
  CHECK(std::count(left.begin(), first_after, 2) == first_after - left.begin());
  CHECK(std::count(first_after, left.end(), jobs + 2) == left.end() - first_after);
  CHECK(first_after != left.begin());
  CHECK(first_after != left.end());
}

TEST_CASE("a killed process keeps every commit that it reported") {
  const TemporaryDirectory directory;
  std::uint64_t next = 0;  // row that the next process starts with
  for (int life = 0; life < 12; ++life) {
    CAPTURE(life);
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      DiskStore store(directory.path());
      store.put_job(stored_job(1));
      for (std::uint64_t row = next;; ++row) {
        store.append_rows(1, std::to_string(row) + std::string(row % 7 * 1000, '.'));
        if (row % 5 == 0) put_picture(store, 1, "picture of " + std::to_string(row));
        store.commit();
        if (write(ends[1], &row, sizeof(row)) != sizeof(row)) _exit(1);
      }
    }
    close(ends[1]);
    std::uint64_t told = 0;
    REQUIRE(read(ends[0], &told, sizeof(told)) == sizeof(told));
    std::this_thread::sleep_for(std::chrono::milliseconds(3 * life));
    kill(child, SIGKILL);
    REQUIRE(waitpid(child, nullptr, 0) == child);
    for (std::uint64_t row = 0; read(ends[0], &row, sizeof(row)) == sizeof(row);) told = row;
    close(ends[0]);
    DiskStore store(directory.path());
    const Strings rows = rows_of(store, 1);
    CHECK(rows.size() > told);
    CHECK(rows.size() <= told + 2);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      CHECK(rows[row] == std::to_string(row) + std::string(row % 7 * 1000, '.'));
    }
    CHECK(store.picture(1) == "picture of " + std::to_string((rows.size() - 1) / 5 * 5));
    CHECK(bulk_files(directory.path()).size() == 2);
    next = rows.size();
  }
}

}  // namespace parray::test
