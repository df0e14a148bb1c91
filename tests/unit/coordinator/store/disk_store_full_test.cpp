// Tests that a DiskStore loses nothing on a disk that is full or read-only.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <csignal>

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

/// A disk whose files cannot grow beyond a limit.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    static_cast<void>(std::signal(SIGXFSZ, handler_));
  }
  FileSizeLimit& operator=(FileSizeLimit&&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("results without room hold back their own job, and dropped data frees room") {
  const TemporaryDirectory directory;
  FaultyDisk disk;
  DiskStore store(directory.path(), disk);
  put_first(store);
  disk.room = 0;
  store.append_rows(1, "row 3");
  store.put_job(stored_job(1, JobState::running));
  store.drop_job(2);
  CHECK_THROWS_AS(store.commit(), StorageFull);
  CHECK(bulk_files(directory.path()) == Strings{"jobs/1/rows", "scenes/" + digest('a')});
  const fs::path crashed = directory.path() / "crashed";
  fs::create_directory(crashed);
  for (const char* name : {"parray.sqlite", "parray.sqlite-wal", "commits", "jobs", "scenes"}) {
    fs::copy(directory.path() / name, crashed / name, fs::copy_options::recursive);
  }
  {
    DiskStore left(crashed);
    REQUIRE(left.jobs().size() == 1);
    CHECK(left.jobs()[0].state == JobState::queued);
    CHECK(rows_of(left, 1).size() == 2);
  }
  disk.room = FaultyDisk::endless;
  store.commit();
  CHECK(rows_of(store, 1) == Strings{"row 1", "row 2", "row 3"});
  CHECK(store.jobs()[0].state == JobState::running);
}

TEST_CASE("a database without room stores nothing of a commit, and all of it later") {
  const TemporaryDirectory directory(in_memory());
  const fs::path state = directory.path() / "state";
  const fs::path crashed = directory.path() / "crashed";
  DiskStore store(state);
  put_first(store);
  const StoredState before = stored_state(store);
  const std::uint64_t log_bytes = files_below(state)["parray.sqlite-wal"];
  REQUIRE(log_bytes > 10'000);
  put_second(store);
  const StoredState after = stored_state(store);
  for (std::uint64_t more = 0; more < 12'000; more += 512) {
    CAPTURE(more);
    bool failed = false;
    {
      const FileSizeLimit limit(log_bytes + more);
      try {
        store.commit();
      } catch (const StorageFull&) {
        failed = true;
      }
    }
    if (!failed) {
      CHECK(more > 0);
      break;
    }
    copy_state(state, crashed);
    CHECK(stored_state(crashed) == before);
    CHECK(stored_state(store) == after);
  }
  store.commit();
  copy_state(state, crashed);
  CHECK(stored_state(crashed) == after);
}

TEST_CASE("a disk that is full to the last byte can still be cleared") {
  const TemporaryDirectory directory(in_memory());
  DiskStore store(directory.path());
  put_first(store);
  const auto full_at = [&] { return files_below(directory.path())["parray.sqlite-wal"]; };
  store.put_job(stored_job(5));
  CHECK(fs::exists(directory.path() / "reserve"));
  {
    const FileSizeLimit limit(full_at());
    CHECK_THROWS_AS(store.commit(), StorageFull);  // frees nothing, so it may not use the reserve
    CHECK(fs::exists(directory.path() / "reserve"));
    store.drop_job(2);
    CHECK_THROWS_AS(store.commit(), StorageFull);  // this limit allows no reserve, unlike a disk
    CHECK_FALSE(fs::exists(directory.path() / "reserve"));
    CHECK(fs::exists(directory.path() / "jobs" / "2" / "picture"));
  }
  store.commit();
  CHECK(fs::exists(directory.path() / "reserve"));
  CHECK_FALSE(fs::exists(directory.path() / "jobs" / "2"));
}

TEST_CASE("a state on a full disk opens and can be read") {
  const TemporaryDirectory directory;
  StoredState before;
  {
    DiskStore store(directory.path());
    put_first(store);
    before = stored_state(store);
  }
  const FileSizeLimit limit(0);
  DiskStore store(directory.path());
  CHECK(stored_state(store) == before);
  store.append_rows(1, "row 3");
  CHECK_THROWS_AS(store.commit(), StorageFull);
  CHECK_THROWS_AS(put_picture(store, 1, "picture"), StorageFull);
}

TEST_CASE("a state that was moved away or cannot be written holds commits until it is back") {
  const TemporaryDirectory directory;
  const fs::path state = directory.path() / "state";
  const fs::path away = directory.path() / "away";
  FaultyDisk disk;
  DiskStore store(state, disk);
  put_first(store);
  store.append_rows(1, "row 3");
  fs::rename(state, away);
  CHECK(message_of<StorageFull>([&] { store.commit(); }).find("moved or removed") !=
        std::string::npos);
  store.put_job(stored_job(7));
  CHECK_THROWS_AS(put_picture(store, 1, "picture"), StorageFull);
  CHECK_FALSE(fs::exists(state));
  fs::rename(away, state);
  for (const int error : {EACCES, EROFS, ENOENT, ENODEV}) {
    disk.error = error;
    const std::string message = message_of<StorageFull>([&] { store.commit(); });
    CHECK_MESSAGE(message.find("make the directory writable again") != std::string::npos, message);
  }
  disk.error = 0;
  store.commit();
  const fs::path crashed = directory.path() / "crashed";
  copy_state(state, crashed);
  DiskStore left(crashed);
  CHECK(rows_of(left, 1).size() == 3);
  CHECK(left.jobs().size() == 3);
}

TEST_CASE("a new state that has no room is refused with the reason") {
  const TemporaryDirectory directory;
  const FileSizeLimit limit(0);
  CHECK_THROWS_WITH_AS(DiskStore{directory.path()}, doctest::Contains("make room"), InputError);
}

}  // namespace parray::test
