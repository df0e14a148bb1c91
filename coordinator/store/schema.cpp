#include "coordinator/store/schema.h"

#include <array>
#include <string>
#include <vector>

#include "coordinator/store/store.h"

namespace parray {
namespace {

constexpr std::uint64_t present_version = 2;

constexpr const char* present_tables =
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
    "  unfinished INTEGER NOT NULL, record TEXT NOT NULL);"
    "CREATE TABLE scenes (digest TEXT PRIMARY KEY, bytes INTEGER NOT NULL,"
    "  checksum INTEGER NOT NULL);"
    "CREATE TABLE pictures (job INTEGER PRIMARY KEY, number INTEGER NOT NULL,"
    "  bytes INTEGER NOT NULL, checksum INTEGER NOT NULL);"
    "CREATE TABLE logs (job INTEGER PRIMARY KEY, number INTEGER NOT NULL, bytes INTEGER NOT NULL);"
    "PRAGMA user_version = 2;";

/// Added since, to states of the present version too.
constexpr const char* later_tables =
    "CREATE TABLE IF NOT EXISTS notes (name TEXT PRIMARY KEY, text TEXT NOT NULL);";

/// What a job of version 1 becomes.
struct Converted {
  JobRecord record;
  bool has_picture = false;
  WholeFile picture;
};

std::vector<Converted> jobs_of_version_1(Database& database) {
  std::vector<Converted> jobs;
  Statement rows(database, "SELECT id, record FROM jobs");
  while (rows.step()) {
    Converted job{record_from_json(rows.number(0), rows.bytes(1)), false, {}};
    if (is_unfinished(job.record.state)) {
      job.record.state = JobState::cancelled;
      job.record.reason = "kept by an earlier version: submit it again";
    }
    jobs.push_back(std::move(job));
  }
  return jobs;
}

void move_picture(Database& database, StateFiles& files, Converted& job) {
  Statement row(database, "SELECT bytes FROM pictures WHERE job = ?");
  row.bind(job.record.id);
  if (row.step()) {
    const std::array<std::string_view, 1> whole = {row.bytes(0)};
    job.picture = files.write(files.picture(job.record.id, 0), whole);
    job.has_picture = true;
  }
}

void insert(Database& database, const Converted& job) {
  const std::string record = record_to_json(job.record);
  execute(database, "INSERT INTO jobs VALUES (?, ?, 0, ?)", job.record.id, job.record.scene,
          record);
  if (job.has_picture) {
    execute(database, "INSERT INTO pictures VALUES (?, 0, ?, ?)", job.record.id, job.picture.bytes,
            job.picture.checksum);
  }
}

void convert_version_1(Database& database, StateFiles& files) {
  std::vector<Converted> jobs = jobs_of_version_1(database);
  for (Converted& job : jobs) {
    if (job.record.state == JobState::done) {
      move_picture(database, files, job);
    }
  }
  files.sync_directories();
  Transaction transaction(database);
  database.run("DROP TABLE jobs; DROP TABLE scenes; DROP TABLE blocks; DROP TABLE pictures");
  database.run(present_tables);
  for (const Converted& job : jobs) {
    insert(database, job);
  }
  transaction.commit();
}

/// A database that was made without it starts to give room back.
void shrink_from_now_on(Database& database) {
  if (database.number("PRAGMA auto_vacuum") != 0) {
    return;
  }
  try {
    database.run("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)");
  } catch (const StorageFull&) {
    // It takes a little room for a while, which the next life may have.
  }
}

}  // namespace

void ready_database(Database& database, StateFiles& files) {
  database.run("PRAGMA locking_mode = EXCLUSIVE");   // one coordinator a state
  if (database.number("PRAGMA auto_vacuum") == 0) {  // setting it writes, which a full disk refuses
    database.run("PRAGMA auto_vacuum = FULL");
  }
  database.run("PRAGMA journal_mode = WAL");
  database.run("PRAGMA synchronous = FULL");            // a commit outlives a power cut
  database.run("PRAGMA journal_size_limit = 4194304");  // bytes, of the log once it is empty
  const std::uint64_t version = database.number("PRAGMA user_version");
  if (version > present_version) {
    throw RunError("the state in " + files.directory().string() +
                   " is of a later version of ParRay");
  }
  if (version == 0) {
    Transaction transaction(database);
    database.run(present_tables);
    transaction.commit();
  } else if (version < present_version) {
    convert_version_1(database, files);
  }
  if (database.number("SELECT COUNT(*) FROM sqlite_master WHERE name = 'notes'") == 0) {
    database.run(later_tables);  // only then: it writes, which a full disk refuses
  }
  shrink_from_now_on(database);
}

}  // namespace parray
