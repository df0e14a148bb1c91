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
#include "coordinator/store/schema.h"
#include "coordinator/store/state_tools.h"
#include "tests/support/damage.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

const char* const scene_text = "the scene of all jobs";

std::string real_digest() { return sha256_hex(as_byte_span(scene_text)); }

JobRecord job_with(JobId id, JobState state) {
  JobRecord job = stored_job(id, state);
  job.name = "name of " + std::to_string(id);
  job.scene = real_digest();
  return job;
}

/// The acknowledged content of jobs.
struct Acknowledged {
  std::map<JobId, std::string> pictures;           ///< of done jobs
  std::map<JobId, std::vector<std::string>> rows;  ///< of unfinished jobs
};

void submit(Store& store, Acknowledged& acknowledged, JobId id) {
  store.put_scene(real_digest(), scene_text);
  store.put_job(job_with(id, JobState::queued));
  store.append_rows(id, "first row of " + std::to_string(id));
  store.commit();
  acknowledged.rows[id] = {"first row of " + std::to_string(id)};
}

void trace(Store& store, Acknowledged& acknowledged, JobId id) {
  const std::string row = "row " + std::string(id * 50, 'r');
  store.append_rows(id, row);
  store.commit();
  acknowledged.rows[id].push_back(row);
}

void finish(Store& store, Acknowledged& acknowledged, JobId id) {
  const std::string picture = "picture of " + std::to_string(id) + std::string(id * 100, 'p');
  put_picture(store, id, picture);
  store.put_job(job_with(id, JobState::done));
  store.drop_work(id);
  store.commit();
  acknowledged.rows.erase(id);
  acknowledged.pictures[id] = picture;
}

/// Puts job 1, which is done and keeps its scene for labels.
void put_labelled_job(Store& store, bool denoise) {
  JobRecord job = job_with(1, JobState::done);
  job.denoise = denoise;
  job.drawing = "{}";
  store.put_scene(real_digest(), scene_text);
  put_picture(store, 1, "picture");
  store.put_job(job);
  store.drop_work(1);
  store.commit();
}

/// Makes five jobs: 1, 2 and 3 are done, 5 is deleted, and 6 is committed with a note. Calls
/// `between` in the middle.
template <typename Between>
Acknowledged live(Store& store, const Between& between) {
  Acknowledged acknowledged;
  for (JobId id = 1; id <= 3; ++id) {
    submit(store, acknowledged, id);
  }
  finish(store, acknowledged, 1);
  between();
  for (JobId id = 4; id <= 6; ++id) {
    submit(store, acknowledged, id);
    trace(store, acknowledged, id - 1);
  }
  finish(store, acknowledged, 2);
  finish(store, acknowledged, 3);
  store.drop_job(5);
  store.put_note("workers", "some");
  store.commit();
  acknowledged.rows.erase(5);
  trace(store, acknowledged, 6);
  return acknowledged;
}

/// A state after `kill -9`, with all files open.
Acknowledged make_killed_state(const fs::path& directory, const fs::path& workshop) {
  DiskStore store(workshop);
  const Acknowledged acknowledged = live(store, [] {});
  copy_state(workshop, directory);
  return acknowledged;
}

bool names(const Strings& lines, JobId id) {
  const std::string number = std::to_string(id);
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    return line.find("job " + number) != std::string::npos ||
           line.find("jobs/" + number + "/") != std::string::npos;
  });
}

/// Checks that every acknowledged job is correct, or that `lines` name the job or the scene.
void check_all(const fs::path& directory, const Acknowledged& acknowledged, Strings lines) {
  DiskStore store(directory);
  lines.insert(lines.end(), store.reports().begin(), store.reports().end());
  CAPTURE(doctest::toString(lines.size()));
  std::map<JobId, JobState> states;
  for (const JobRecord& job : store.jobs()) {
    states[job.id] = job.state;
  }
  const auto right = [&](const auto& what, const auto& expected) {
    try {
      return what() == expected;
    } catch (const RunError& error) {
      lines.emplace_back(error.what());
      return false;
    }
  };
  for (const auto& [id, picture] : acknowledged.pictures) {
    const bool there = states.contains(id) && states.at(id) == JobState::done &&
                       right([&, id = id] { return store.picture(id).value_or(""); }, picture);
    CHECK_MESSAGE((there || names(lines, id)), "job " << id << " has lost its picture silently");
  }
  for (const auto& [id, rows] : acknowledged.rows) {
    const bool there = states.contains(id) && states.at(id) == JobState::queued &&
                       right([&, id = id] { return rows_of(store, id); }, rows);
    CHECK_MESSAGE((there || names(lines, id)), "job " << id << " has lost rows silently");
  }
  CHECK_FALSE(states.contains(5));
}

void check_whole(const fs::path& directory, const Acknowledged& acknowledged) {
  check_all(directory, acknowledged, {});
  DiskStore store(directory);
  CHECK(store.reports() == Strings{});
  CHECK(store.jobs().size() == acknowledged.pictures.size() + acknowledged.rows.size());
  CHECK(store.scene(real_digest()) == scene_text);
  CHECK(store.note("workers") == "some");
}

/// Checks that opening fails and names --repair, and that --repair restores everything.
void check_mended(const fs::path& directory, const Acknowledged& acknowledged) {
  const auto files = [&] {  // ignores an empty write-ahead log
    auto found = files_below(directory);
    std::erase_if(found, [](const auto& file) { return file.second == 0; });
    return found;
  };
  const auto before = files();
  const std::string message = message_of<StateDamaged>([&] { const DiskStore store(directory); });
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
  for (const auto& [name, bytes] : before) {
    CHECK(file_bytes(directory.path() / name) == bytes);
  }
  CHECK_THROWS_AS(find_damage(directory.path() / "jobs"), InputError);
  CHECK_THROWS_AS(find_damage(directory.path() / "nowhere"), InputError);
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
  const char* more = std::getenv("PARRAY_DAMAGES");  // NOLINT(concurrency-mt-unsafe)
  const std::uint64_t histories = more == nullptr ? 300 : std::strtoull(more, nullptr, 10);
  std::uint64_t refused = 0;
  std::uint64_t lossy = 0;
  for (std::uint64_t seed = 1; seed <= histories; ++seed) {
    CAPTURE(seed);
    copy_state(seed % 2 == 0 ? killed : closed, damaged);
    Damage damage(damaged, seed);
    std::string done;
    for (std::uint64_t blows = 1 + seed % 3; blows > 0; --blows) {
      done += damage.strike() + "; ";
    }
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
  for (const auto& [name, size] : files_below(killed)) {
    CAPTURE(name);
    for (const bool pipe : {false, true}) {
      copy_state(killed, damaged);
      fs::remove(damaged / name);
      REQUIRE((pipe ? mkfifo((damaged / name).c_str(), 0600) == 0
                    : fs::create_directories(damaged / name / "inside")));
      const auto is_it = [&, name = name](const std::string& line) {
        return line.starts_with(name + " is a ");
      };
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
      if (id % 2 == 0) {
        finish(store, fresh, id);
      }
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
    for (const auto& [id, picture] : before.pictures) {
      CHECK(restored.picture(id) == picture);
    }
    for (const auto& [id, rows] : before.rows) {
      CHECK(rows_of(restored, id) == rows);
    }
  }
  stop = true;
  CHECK_THROWS_AS(back_up_state(state, directory.path() / "copy0", 1e9), InputError);
}

}  // namespace parray::test
