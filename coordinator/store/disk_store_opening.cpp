// Opening and tidying a DiskStore.
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <system_error>
#include <utility>

#include "coordinator/store/disk_store.h"
#include "coordinator/store/records.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

/// Returns the size in bytes; nothing: the file does not exist.
std::optional<std::uint64_t> size_of(const fs::path& file) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  return error ? std::nullopt : std::optional(size);
}

bool is_cut(const fs::path& file, std::uint64_t bytes) {
  const std::optional<std::uint64_t> size = size_of(file);
  return !size || *size < bytes;
}

/// Checks that the committed bytes of each rows file end with an entry. Only then may opening cut
/// off uncommitted entries, which a crash has left.
void check_ends_of_rows(const StateFiles& files, const Records& records, Comparison& comparison) {
  for (const auto& [id, row] : records.jobs) {
    if (!row.rows) continue;
    const fs::path file = files.rows(id, row.rows->number);
    if (size_of(file).value_or(0) > row.rows->bytes && !ends_an_entry(file, row.rows->bytes)) {
      comparison.severe.push_back("the length in the database of jobs/" + std::to_string(id) + "/" +
                                  file.filename().string() + " ends within an entry of this file");
    }
  }
}

/// Throws StateDamaged if something other than a file has the name of one of SQLite's files.
void check_place_of_database(const StateFiles& files, const std::vector<Misplaced>& misplaced) {
  for (const auto& [path, line] : misplaced) {
    if (path.string().starts_with(files.database().string())) {
      throw StateDamaged(files.directory(), {line});
    }
  }
}

/// Locks the database for this process until `database` is destroyed, and creates the tables of a
/// new state. Throws InputError for a state of another version. States of earlier versions do not
/// have the file `commits`.
void ready_database(Database& database, const StateFiles& files, const FoundFiles& found) {
  database.run("PRAGMA locking_mode = EXCLUSIVE");  // only one coordinator per state
  const std::uint64_t version = database.number("PRAGMA user_version");
  if (version == 0 && !found.empty()) {
    throw StateDamaged(files.directory(), {"the database has lost its content"});
  }
  if (version != 0 && version < present_version && found.has_commits) {
    throw StateDamaged(files.directory(), {older_database});
  }
  if (version != 0 && version != present_version) {
    throw InputError(other_version_text(files.directory(), version));
  }
  if (database.number("PRAGMA auto_vacuum") == 0) {  // a full disk refuses the write
    database.run("PRAGMA auto_vacuum = FULL");
  }
  database.run("PRAGMA journal_mode = WAL");
  database.run("PRAGMA synchronous = FULL");            // commits survive a power failure
  database.run("PRAGMA journal_size_limit = 4194304");  // bytes of an empty log file
  if (version == 0) {
    Transaction transaction(database);
    make_tables(database);
    transaction.commit();
  }
}

std::string damage_text(const std::filesystem::path& directory,
                        const std::vector<std::string>& damage) {
  const std::string place = directory.string();
  const std::string more =
      damage.size() > 1 ? " (and " + std::to_string(damage.size() - 1) + " more)" : "";
  return place + ": the state is damaged: " + damage.front() + more +
         ": parray-coordinator --check " + place + " lists the damage, --repair " + place +
         " repairs it";
}

}  // namespace

StateDamaged::StateDamaged(const std::filesystem::path& directory,
                           const std::vector<std::string>& damage)
    : RunError(damage_text(directory, damage)) {}

DiskStore::DiskStore(const fs::path& directory, Disk& disk) : files_(directory, disk) {
  try {
    open();
  } catch (const StorageFull& error) {
    throw InputError(error.what());
  } catch (const DatabaseDamaged& error) {
    throw StateDamaged(files_.directory(), {error.what()});
  }
}

void DiskStore::open() {
  const std::vector<Misplaced> misplaced = find_misplaced(files_);
  check_place_of_database(files_, misplaced);
  FoundFiles found = find_files(files_);
  if (size_of(files_.database()).value_or(0) == 0 && !found.empty()) {
    throw StateDamaged(files_.directory(), {"parray.sqlite is missing or empty"});
  }
  database_ = std::make_unique<Database>(files_.database());
  database_->keep_log_on_close(true);  // a damaged state stays as it is
  const Records records = read_database(found);
  Comparison comparison = compare(records, found);
  check_ends_of_rows(files_, records, comparison);
  if (!comparison.severe.empty()) throw StateDamaged(files_.directory(), comparison.severe);
  database_->keep_log_on_close(false);
  load(records);
  reports_ = move_misplaced_to_lost(files_, misplaced, uptime());
  for (const std::string& line : comparison.minor) {
    reports_.push_back(line + ": will be written again from the database");
  }
  apply_upkeep(comparison.upkeep, found, records);
  check_files();
  database_log_is_empty_ = false;
  tidy(std::numeric_limits<double>::infinity());
}

Records DiskStore::read_database(const FoundFiles& found) {
  ready_database(*database_, files_, found);
  Statement check(*database_, "PRAGMA quick_check(1)");
  if (check.step() && check.bytes(0) != "ok") {
    throw DatabaseDamaged("parray.sqlite: " + std::string(check.bytes(0)));
  }
  return read_records(*database_);
}

void DiskStore::load(const Records& records) {
  batch_ = records.batch;
  for (const auto& [id, row] : records.jobs) {
    JobEntry& entry = jobs_[id];
    entry = {row.scene, row.unfinished, row.record.has_value()};
    if (row.rows) entry.log = {row.rows->number, row.rows->bytes};
    entry.picture = row.picture;
  }
  scenes_ = records.scenes;
}

/// Finishes a commit that a crash interrupted, and rewrites damaged copies.
void DiskStore::apply_upkeep(const Upkeep& upkeep, const FoundFiles& found,
                             const Records& records) {
  for (const JobId id : upkeep.finish) put_in_place(files_.job_next(id), files_.job_json(id));
  for (const JobId id : upkeep.restore) put_in_place(files_.job_dropped(id), files_.job_json(id));
  for (const JobId id : upkeep.remove_next) StateFiles::remove(files_.job_next(id));
  for (const JobId id : upkeep.remove_dropped) {
    const JobFile& dropped = *found.jobs.at(id).dropped;
    if (dropped.rows) StateFiles::remove(files_.rows(id, dropped.rows->number));
    if (dropped.picture) StateFiles::remove(files_.picture(id, dropped.picture->number));
    StateFiles::remove(files_.job_dropped(id));
  }
  const auto write = [&](const fs::path& file, const std::string& text) {
    try {
      files_.write(file, text);
    } catch (const RunError& error) {
      reports_.emplace_back(error.what());  // the next opening tries again
    }
  };
  for (const JobId id : upkeep.rewrite) {
    const JobRow& row = records.jobs.at(id);
    write(files_.job_json(id),
          job_file_to_text(id, {row.batch, *row.record, row.rows, row.picture}));
  }
  if (upkeep.finish_notes) {
    put_in_place(files_.notes_next(), files_.notes_json());
  } else if (upkeep.rewrite_notes) {
    write(files_.notes_json(), notes_file_to_text({records.notes_batch, records.notes}));
  }
  counts_commits_ = found.commits.has_value();
}

/// Moves files that no record names to lost/, and reports missing files.
void DiskStore::check_files() {
  std::set<fs::path> named;
  const auto name = [&](const fs::path& file, std::uint64_t bytes) {
    named.insert(file);
    if (size_of(file).value_or(0) < bytes) {
      reports_.push_back(file.lexically_relative(files_.directory()).string() +
                         " is missing or cut");
    }
  };
  for (const auto& [digest, file] : scenes_) name(files_.scene(digest), file.bytes);
  for (const auto& [id, entry] : jobs_) {
    if (entry.log) {
      const fs::path rows = files_.rows(id, entry.log->number);
      StateFiles::cut(rows, entry.log->committed);
      name(rows, entry.log->committed);
    }
    if (entry.picture) name(files_.picture(id, entry.picture->number), entry.picture->file.bytes);
    if (entry.has_record) named.insert(files_.job_json(id));
  }
  const std::uint64_t stamp = uptime();
  for (const fs::path& file : files_.move_unnamed_to_lost(named, stamp)) {
    reports_.push_back(file.lexically_relative(files_.directory()).string() +
                       " is named by no record: moved to lost/" + std::to_string(stamp));
  }
  lost_bytes_ = files_.lost_bytes();
}

bool DiskStore::lacks_files() {
  const bool lacks_scene = std::ranges::any_of(scenes_, [this](const auto& scene) {
    return is_cut(files_.scene(scene.first), scene.second.bytes);
  });
  return lacks_scene || std::ranges::any_of(jobs_, [this](const auto& job) {
           const auto& [id, entry] = job;
           return (entry.log && is_cut(files_.rows(id, entry.log->number), entry.log->committed)) ||
                  (entry.picture &&
                   is_cut(files_.picture(id, entry.picture->number), entry.picture->file.bytes));
         });
}

void DiskStore::tidy(double keep_lost) {
  if (!std::exchange(database_log_is_empty_, true)) {
    try {
      database_->run("PRAGMA wal_checkpoint(TRUNCATE)");
    } catch (const StorageFull&) {
      database_log_is_empty_ = false;
    } catch (const InputError&) {  // the database is not writable now
      database_log_is_empty_ = false;
    }
  }
  if (lost_bytes_ > 0) {
    files_.remove_lost(static_cast<double>(uptime()) - keep_lost);
    lost_bytes_ = files_.lost_bytes();
  }
}

/// Returns the uptime in seconds.
std::uint64_t DiskStore::uptime() { return std::strtoull(note(uptime_note).c_str(), nullptr, 10); }

}  // namespace parray::store
