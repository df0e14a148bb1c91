// A primary and its standby with states on disk, one of which is damaged, copied or repaired.
#include <doctest/doctest.h>

#include <memory>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "coordinator/store/disk_store.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/state_tools.h"
#include "tests/support/rooms.h"
#include "tests/support/standby_line.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

const char* const scene_text = "the scene of all jobs";
std::string scene_digest() { return sha256_hex(as_byte_span(scene_text)); }

JobRecord job_of(JobId id, JobState state) {
  JobRecord job = stored_job(id, state);
  job.scene = scene_digest();
  return job;
}

/// Primary and standby with states on disk. Each can be stopped and restarted.
class Twins {
 public:
  Twins() { start(); }

  void start() {
    standby_disk = std::make_unique<DiskStore>(second());
    line = std::make_unique<Standby>(*standby_disk);
    primary_disk = std::make_unique<DiskStore>(first());
    primary = std::make_unique<ReplicatedStore>(*primary_disk, *line, numbers(++seed_));
  }
  void stop() {
    primary.reset();
    primary_disk.reset();
    line.reset();
    standby_disk.reset();
  }

  /// Job 1 is done, job 2 has two rows.
  void work() const {
    primary->put_scene(scene_digest(), scene_text);
    primary->put_job(job_of(1, JobState::done));
    put_picture(*primary, 1, "the picture of job 1");
    primary->put_job(job_of(2, JobState::running));
    primary->append_rows(2, "first row");
    primary->append_rows(2, "second row");
    primary->commit();
  }

  /// Checks that both stores have committed the same content.
  void check_same() const {
    const StoredState of_primary = stored_state(*primary_disk);
    CHECK(of_primary == stored_state(*standby_disk));
    CHECK(primary_disk->scene(scene_digest()) == standby_disk->scene(scene_digest()));
  }

  [[nodiscard]] fs::path first() const { return directory_.path() / "first"; }
  [[nodiscard]] fs::path second() const { return directory_.path() / "second"; }
  [[nodiscard]] fs::path other() const { return directory_.path() / "other"; }

  std::unique_ptr<DiskStore> standby_disk;
  std::unique_ptr<Standby> line;
  std::unique_ptr<DiskStore> primary_disk;
  std::unique_ptr<ReplicatedStore> primary;

 private:
  TemporaryDirectory directory_{in_memory()};
  std::uint64_t seed_ = 0;
};

/// Checks that the store has everything that work() acknowledged.
void check_work(Store& store) {
  CHECK(store.picture(1) == "the picture of job 1");
  CHECK(rows_of(store, 2) == std::vector<std::string>{"first row", "second row"});
  CHECK(store.scene(scene_digest()) == scene_text);
}

void put_directory_in_place_of(const fs::path& file) {
  REQUIRE(fs::remove(file));
  fs::create_directories(file / "inside");
}

fs::path scene_file() { return fs::path("scenes") / scene_digest(); }

}  // namespace

TEST_CASE("a standby whose files were replaced by directories gets them again before it serves") {
  for (const fs::path& file : {fs::path("jobs/1/picture"), fs::path("jobs/2/rows"), scene_file()}) {
    for (const bool started_twice : {false, true}) {
      CAPTURE(file);
      CAPTURE(started_twice);
      Twins twins;
      twins.work();
      twins.stop();
      put_directory_in_place_of(twins.second() / file);
      if (started_twice) const DiskStore moves_it_away(twins.second());
      twins.start();
      twins.primary->commit();
      CHECK(twins.line->replica().in_step());
      check_work(*twins.standby_disk);
      serve_alone(*twins.standby_disk);
      check_work(*twins.standby_disk);
    }
  }
}

TEST_CASE("a primary whose files were replaced by directories stays in step with its standby") {
  Twins twins;
  twins.work();
  twins.stop();
  SUBCASE("its picture comes back from the standby") {
    put_directory_in_place_of(twins.first() / "jobs/1/picture");
    twins.start();
    twins.primary->commit();
    CHECK(twins.primary->restore_picture(1));
    twins.primary->commit();
    check_work(*twins.primary_disk);
  }
  SUBCASE("its rows are traced again, and both have the same") {
    put_directory_in_place_of(twins.first() / "jobs/2/rows");
    twins.start();
    twins.primary->keep_rows(2, 0);  // as the coordinator does for damaged results
    twins.primary->append_rows(2, "first row, traced again");
    twins.primary->commit();
    CHECK(rows_of(*twins.standby_disk, 2) == std::vector<std::string>{"first row, traced again"});
  }
  twins.check_same();
}

TEST_CASE("a backup of a standby's state serves what was acknowledged") {
  Twins twins;
  twins.work();
  CHECK(back_up_state(twins.second(), twins.other(), 1e9) == std::vector<std::string>{});
  DiskStore copy(twins.other());
  CHECK_NOTHROW(serve_alone(copy));
  check_work(copy);
}

TEST_CASE("a backup of a standby's state becomes a standby again through a full copy") {
  Twins twins;
  twins.work();
  CHECK(back_up_state(twins.second(), twins.other(), 1e9) == std::vector<std::string>{});
  twins.primary->append_rows(2, "third row");
  twins.primary->commit();
  twins.stop();
  fs::remove_all(twins.second());
  fs::rename(twins.other(), twins.second());
  twins.start();
  twins.primary->commit();
  CHECK(twins.line->replica().in_step());
  CHECK(rows_of(*twins.standby_disk, 2).size() == 3);
  twins.check_same();
}

TEST_CASE("a repaired state of a standby can serve, or gets a full copy from its primary") {
  Twins twins;
  twins.work();
  twins.stop();
  fs::remove(twins.second() / "parray.sqlite");
  CHECK_THROWS_AS(DiskStore{twins.second()}, StateDamaged);
  CHECK_FALSE(repair_state(twins.second(), 1e9).empty());
  SUBCASE("its primary is gone") {
    DiskStore repaired(twins.second());
    CHECK_NOTHROW(serve_alone(repaired));
    check_work(repaired);
  }
  SUBCASE("its primary is there") {
    twins.start();
    CHECK_FALSE(twins.line->replica().in_step());
    twins.primary->append_rows(2, "third row");
    twins.primary->commit();
    CHECK(twins.line->replica().in_step());
    CHECK(rows_of(*twins.standby_disk, 2).size() == 3);
    twins.check_same();
  }
}

TEST_CASE("an incomplete copy cannot serve, even after a repair, and cannot be backed up") {
  Twins twins;
  twins.work();
  twins.stop();
  fs::remove_all(twins.second());
  twins.standby_disk = std::make_unique<DiskStore>(twins.second());
  twins.line = std::make_unique<Standby>(*twins.standby_disk);
  twins.primary_disk = std::make_unique<DiskStore>(twins.first());
  twins.primary = std::make_unique<ReplicatedStore>(*twins.primary_disk, *twins.line, numbers(7));
  twins.line->last_call = 2;  // hello, copy
  CHECK_THROWS_AS(twins.primary->commit(), StorageFull);
  twins.stop();
  SUBCASE("as it is") {}
  SUBCASE("and is not backed up") {
    CHECK_THROWS_WITH_AS(back_up_state(twins.second(), twins.other(), 1e9),
                         doctest::Contains("is receiving a full copy"), InputError);
    CHECK_FALSE(fs::exists(twins.other()));
  }
  SUBCASE("repaired") {
    fs::remove(twins.second() / "parray.sqlite");
    repair_state(twins.second(), 1e9);
  }
  DiskStore store(twins.second());
  CHECK_THROWS_AS(serve_alone(store), InputError);
}

}  // namespace parray::test
