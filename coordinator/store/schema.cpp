#include "coordinator/store/schema.h"

#include <array>
#include <string>
#include <vector>

#include "coordinator/store/store.h"

namespace parray::store {
namespace {

constexpr const char* tables_of_version_2 =
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
    "  unfinished INTEGER NOT NULL, record TEXT NOT NULL);"
    "CREATE TABLE scenes (digest TEXT PRIMARY KEY, bytes INTEGER NOT NULL,"
    "  checksum INTEGER NOT NULL);"
    "CREATE TABLE pictures (job INTEGER PRIMARY KEY, number INTEGER NOT NULL,"
    "  bytes INTEGER NOT NULL, checksum INTEGER NOT NULL);"
    "CREATE TABLE logs (job INTEGER PRIMARY KEY, number INTEGER NOT NULL, bytes INTEGER NOT NULL);"
    "PRAGMA user_version = 2;";

/// Early states of version 2 lack the notes.
constexpr const char* to_version_3 =
    "CREATE TABLE IF NOT EXISTS notes (name TEXT PRIMARY KEY, text TEXT NOT NULL);"
    "ALTER TABLE jobs ADD COLUMN batch INTEGER NOT NULL DEFAULT 1;"
    "PRAGMA user_version = 3;";

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
  files.sync();
  Transaction transaction(database);
  database.run("DROP TABLE jobs; DROP TABLE scenes; DROP TABLE blocks; DROP TABLE pictures");
  database.run(tables_of_version_2);
  for (const Converted& job : jobs) {
    insert(database, job);
  }
  transaction.commit();
}

/// Copies of what the database holds, as those of a commit under way. Rows that earlier versions
/// filled otherwise become like their records.
void write_copies(Database& database, Records records, StateFiles& files) {
  for (auto& [id, row] : records.jobs) {
    if (row.record) {
      complete_row(id, row);  // throws where the record is damaged
      execute(database, "UPDATE jobs SET scene = ?, unfinished = ? WHERE id = ?", row.scene,
              std::uint64_t{row.unfinished ? 1U : 0U}, id);
      files.overwrite(files.job_next(id),
                      job_file_to_text(id, {row.batch, *row.record, row.rows, row.picture}));
    }
  }
  files.overwrite(files.notes_next(), notes_file_to_text({records.notes_batch, records.notes}));
  files.sync();
}

void convert_version_2(Database& database, StateFiles& files) {
  Transaction transaction(database);
  database.run(to_version_3);
  database.run("INSERT INTO notes SELECT 'reached', text FROM notes WHERE name = 'mark'");
  write_note(database, own_note::batch, "1");
  write_note(database, own_note::notes_batch, "1");
  write_copies(database, read_records(database), files);
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

void make_tables(Database& database) {
  database.run(tables_of_version_2);
  database.run(to_version_3);
}

bool ready_database(Database& database, StateFiles& files, const FoundFiles& found) {
  database.run("PRAGMA locking_mode = EXCLUSIVE");  // one coordinator a state
  const std::uint64_t version = database.number("PRAGMA user_version");
  if (version > present_version) {
    throw RunError("the state in " + files.directory().string() +
                   " is of a later version of ParRay");
  }
  if (version == 0 && !found.fresh()) {
    throw StateDamaged(files.directory(), {"the database has lost its content"});
  }
  if (version > 0 && version < present_version && found.has_commits) {
    throw StateDamaged(files.directory(), {"the database is of an earlier version than the jobs"});
  }
  if (database.number("PRAGMA auto_vacuum") == 0) {  // setting it writes, which a full disk refuses
    database.run("PRAGMA auto_vacuum = FULL");
  }
  database.run("PRAGMA journal_mode = WAL");
  database.run("PRAGMA synchronous = FULL");            // a commit outlives a power cut
  database.run("PRAGMA journal_size_limit = 4194304");  // bytes, of the log once it is empty
  if (version == 0) {
    Transaction transaction(database);
    make_tables(database);
    transaction.commit();
  } else if (version < present_version) {
    if (version == 1) {
      convert_version_1(database, files);
    }
    convert_version_2(database, files);
  }
  shrink_from_now_on(database);
  return version > 0 && version < present_version;
}

static std::string damage_text(const std::filesystem::path& directory,
                               const std::vector<std::string>& damage) {
  const std::string place = directory.string();
  const std::string more =
      damage.size() > 1 ? " (and " + std::to_string(damage.size() - 1) + " more)" : "";
  return "--state " + place + " is damaged: " + damage.front() + more +
         ": parray-coordinator --check " + place + " lists the damage, --repair " + place +
         " mends it";
}

StateDamaged::StateDamaged(const std::filesystem::path& directory,
                           const std::vector<std::string>& damage)
    : RunError(damage_text(directory, damage)) {}

}  // namespace parray::store
