// Tests that a damaged state loses nothing acknowledged without a message.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "coordinator/store/database.h"
#include "coordinator/store/row_log.h"
#include "coordinator/store/state_tools.h"
#include "tests/support/acknowledged.h"
#include "tests/support/damage.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/trials.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

/// Checks that opening fails and names --repair, and that --repair restores everything.
void check_mended(const fs::path& directory, const Acknowledged& acknowledged) {
  const auto files = [&] {  // ignores an empty write-ahead log
    auto found = files_below(directory);
    std::erase_if(found, [](const auto& file) { return file.second == 0; });
    return found;
  };
  const auto before = files();
  const std::string message = message_of<StateDamaged>([&] { const DiskStore store(directory); });
  CHECK_MESSAGE(message.starts_with(directory.string() + ": the state is damaged: "), message);
  CHECK_MESSAGE(message.find("--repair " + directory.string()) != std::string::npos, message);
  CHECK_FALSE(find_damage(directory).empty());
  CHECK(files() == before);
  CHECK_FALSE(repair_state(directory, 1e9).empty());
  CHECK(find_damage(directory) == Strings{});
  CHECK(repair_state(directory, 1e9) == Strings{});
  check_whole(directory, acknowledged);
}

}  // namespace

TEST_CASE("a write-ahead log that is damaged anywhere loses no job") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(killed, directory.path() / "workshop");
  const std::string log = file_bytes(killed / "parray.sqlite-wal");
  REQUIRE(log.size() > 40'000);
  int refused = 0;
  for (std::size_t at = 0; at < log.size(); at += 4001) {
    CAPTURE(at);
    copy_state(killed, damaged);
    std::string changed = log;
    changed[at] = static_cast<char>(~changed[at]);
    write_bytes(damaged / "parray.sqlite-wal", changed);
    if (find_damage(damaged).empty()) {
      check_whole(damaged, acknowledged);  // SQLite does not read these bytes
    } else {
      ++refused;
      check_mended(damaged, acknowledged);
    }
    copy_state(killed, damaged);
    write_bytes(damaged / "parray.sqlite-wal", log.substr(0, at));
    check_mended(damaged, acknowledged);
  }
  CHECK(refused > 5);
}

TEST_CASE("a database that is missing, cut, overwritten or out of date loses no job") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path older = directory.path() / "older";
  const fs::path damaged = directory.path() / "damaged";
  const fs::path workshop = directory.path() / "workshop";
  Acknowledged acknowledged;
  {
    DiskStore store(workshop);
    acknowledged = live(store, [&] { copy_state(workshop, older); });
    copy_state(workshop, killed);
  }
  const auto strike = [&](const std::string& what, const auto& blow) {
    CAPTURE(what);
    copy_state(killed, damaged);
    blow();
    check_mended(damaged, acknowledged);
  };
  strike("no log", [&] { fs::remove(damaged / "parray.sqlite-wal"); });
  strike("no database", [&] { fs::remove(damaged / "parray.sqlite"); });
  strike("neither", [&] {
    fs::remove(damaged / "parray.sqlite");
    fs::remove(damaged / "parray.sqlite-wal");
  });
  strike("empty", [&] { fs::resize_file(damaged / "parray.sqlite", 0); });
  strike("garbage", [&] {
    fs::remove(damaged / "parray.sqlite-wal");  // contains the whole database
    write_bytes(damaged / "parray.sqlite", std::string(5000, 'x'));
  });
  strike("older", [&] {
    for (const char* name : {"parray.sqlite", "parray.sqlite-wal"}) {
      fs::copy_file(older / name, damaged / name, fs::copy_options::overwrite_existing);
    }
  });
  strike("no count of commits", [&] { fs::remove(damaged / "commits"); });
}

TEST_CASE("a damaged copy beside the database is written again, and the state can serve") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(killed, directory.path() / "workshop");
  for (const char* name : {"jobs/1/job.json", "jobs/2/job.json", "notes.json"}) {
    for (const bool gone : {false, true}) {
      CAPTURE(name);
      copy_state(killed, damaged);
      const std::string whole = file_bytes(damaged / name);
      gone ? static_cast<void>(fs::remove(damaged / name))
           : write_bytes(damaged / name, whole.substr(0, whole.size() / 2));
      CHECK(find_damage(damaged).size() == 1);
      {
        DiskStore store(damaged);
        REQUIRE(store.reports().size() == 1);
        CHECK(store.reports()[0].find(name) == 0);
      }
      CHECK(file_bytes(damaged / name) == whole);
      check_whole(damaged, acknowledged);
    }
  }
}

TEST_CASE("a finished job that loses its scene stays done, without denoising and labels") {
  const TemporaryDirectory directory;
  {
    DiskStore store(directory.path());
    put_labelled_job(store, true);
  }
  write_bytes(directory.path() / "scenes" / real_digest(), "damaged");
  CHECK(names(repair_state(directory.path(), 1000), 1));
  DiskStore store(directory.path());
  const JobRecord job = store.jobs().at(0);
  CHECK(job.state == JobState::done);
  CHECK_FALSE(job.keeps_scene());
  CHECK(store.picture(1) == "picture");
}

TEST_CASE("a job whose picture is lost has neither progress nor an error any more") {
  const TemporaryDirectory directory(in_memory());
  {
    DiskStore store(directory.path());
    JobRecord job = job_with(1, JobState::done);
    job.course.taken = 3;
    job.course.progress = 1;
    job.course.error.rmse = 0.125;
    put_picture(store, 1, "picture");
    store.put_job(job);
    store.commit();
  }
  std::filesystem::remove(directory.path() / "jobs" / "1" / "picture");
  repair_state(directory.path(), 1e9);
  const JobRecord job = DiskStore(directory.path()).jobs().at(0);
  CHECK(job.state == JobState::failed);
  CHECK(job.course.taken == 3);
  CHECK(job.course.progress == 0);
  CHECK_FALSE(job.course.error.known());
}

TEST_CASE(
    "damaged results, pictures and scenes are reported, and repair keeps the undamaged parts") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(killed, directory.path() / "workshop");
  copy_state(killed, damaged);
  const auto flip = [&](const fs::path& name, std::size_t from_end) {
    std::string bytes = file_bytes(damaged / name);
    bytes[bytes.size() - from_end] ^= 1;
    write_bytes(damaged / name, bytes);
  };
  flip("jobs/2/picture", 5);
  flip("jobs/6/rows", 5);
  CHECK(find_damage(damaged).size() == 2);
  const Strings lines = repair_state(damaged, 1e9);
  CHECK(names(lines, 2));
  CHECK(names(lines, 6));
  CHECK(find_damage(damaged) == Strings{});
  {
    DiskStore store(damaged);
    CHECK(store.jobs()[1].state == JobState::failed);
    CHECK(store.jobs()[1].reason == "its picture is damaged or missing: submit the job again");
    CHECK(rows_of(store, 6) == Strings{"first row of 6"});
    CHECK(rows_of(store, 4) == acknowledged.rows.at(4));
    CHECK(store.picture(1) == acknowledged.pictures.at(1));
    CHECK(fs::exists(damaged / "lost" / "0" / "jobs" / "2" / "picture"));
    CHECK(fs::exists(damaged / "lost" / "0" / "jobs" / "6" / "rows"));
  }
  copy_state(killed, damaged);
  flip(fs::path("scenes") / real_digest(), 1);
  CHECK(find_damage(damaged).size() == 2);  // for each job that needs it
  repair_state(damaged, 1e9);
  DiskStore store(damaged);
  CHECK(store.jobs()[3].state == JobState::failed);
  CHECK(store.jobs()[3].reason == "its scene is damaged or missing: submit the job again");
}

TEST_CASE("after any damage every acknowledged job is correct or reported") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path closed = directory.path() / "closed";
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(killed, closed);
  const std::uint64_t histories = trials(120);
  std::uint64_t refused = 0;
  std::uint64_t lossy = 0;
  for (std::uint64_t seed = 1; seed <= histories; ++seed) {
    CAPTURE(seed);
    copy_state(seed % 2 == 0 ? killed : closed, damaged);
    Damage damage(damaged, seed);
    std::string done;
    for (std::uint64_t blows = 1 + seed % 3; blows > 0; --blows) done += damage.strike() + "; ";
    CAPTURE(done);
    Strings lines;
    try {
      const DiskStore store(damaged);
      lines = store.reports();
    } catch (const StateDamaged&) {
      ++refused;
      lines = repair_state(damaged, 1e9);
    }
    lossy += lines.empty() ? 0 : 1;
    check_all(damaged, acknowledged, lines);
    repair_state(damaged, 1e9);
    CHECK(find_damage(damaged) == Strings{});
  }
  MESSAGE(histories << " histories, seeds 1 to " << histories << ": " << refused
                    << " refused until --repair, " << lossy << " with lines of damage");
  CHECK(refused > histories / 10);
}

TEST_CASE(
    "a directory or pipe in the place of any file is reported, and repair moves it to lost/") {
  const TemporaryDirectory directory(in_memory());
  const fs::path killed = directory.path() / "killed";
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(killed, directory.path() / "workshop");
  for (const auto& file : files_below(killed)) {
    const std::string& name = file.first;  // Clang 14 does not capture a structured binding
    CAPTURE(name);
    for (const bool pipe : {false, true}) {
      copy_state(killed, damaged);
      fs::remove(damaged / name);
      REQUIRE((pipe ? mkfifo((damaged / name).c_str(), 0600) == 0
                    : fs::create_directories(damaged / name / "inside")));
      const auto is_it = [&](const std::string& line) { return line.starts_with(name + " is a "); };
      const Strings lines = find_damage(damaged);
      CHECK(std::ranges::any_of(lines, is_it));
      const Strings done = repair_state(damaged, 1e9);
      CHECK(std::ranges::any_of(done, is_it));
      CHECK(fs::exists(damaged / "lost" / "0" / name));
      CHECK(find_damage(damaged) == Strings{});
      check_all(damaged, acknowledged, done);
    }
  }
}

TEST_CASE("a database whose digest of a scene is damaged is refused, and repair restores it") {
  const TemporaryDirectory directory(in_memory());
  const fs::path damaged = directory.path() / "damaged";
  const Acknowledged acknowledged = make_killed_state(damaged, directory.path() / "workshop");
  {
    store::Database database(damaged / "parray.sqlite");
    database.run("UPDATE scenes SET digest = 'a digest'");
  }
  check_mended(damaged, acknowledged);
}

TEST_CASE("a done job that keeps its scene for labels keeps it through a repair") {
  const TemporaryDirectory directory(in_memory());
  const fs::path damaged = directory.path() / "damaged";
  {
    DiskStore store(damaged);
    put_labelled_job(store, false);
  }
  fs::remove(damaged / "parray.sqlite");
  CHECK_FALSE(repair_state(damaged, 1e9).empty());
  DiskStore store(damaged);
  CHECK(store.scene(real_digest()) == scene_text);
}

}  // namespace parray::test
