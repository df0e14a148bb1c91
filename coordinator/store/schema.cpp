#include "coordinator/store/schema.h"

#include <string>
#include <vector>

namespace parray::store {
namespace {

constexpr const char* tables =
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
    "  unfinished INTEGER NOT NULL, record TEXT NOT NULL, batch INTEGER NOT NULL);"
    "CREATE TABLE scenes (digest TEXT PRIMARY KEY, bytes INTEGER NOT NULL,"
    "  checksum INTEGER NOT NULL);"
    "CREATE TABLE pictures (job INTEGER PRIMARY KEY, number INTEGER NOT NULL,"
    "  bytes INTEGER NOT NULL, checksum INTEGER NOT NULL);"
    "CREATE TABLE logs (job INTEGER PRIMARY KEY, number INTEGER NOT NULL, bytes INTEGER NOT NULL);"
    "CREATE TABLE notes (name TEXT PRIMARY KEY, text TEXT NOT NULL);"
    "PRAGMA user_version = 3;";

}  // namespace

void make_tables(Database& database) { database.run(tables); }

std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version) {
  return "the state in " + directory.string() + " is of version " + std::to_string(version) +
         ", and this program reads version " + std::to_string(present_version) +
         ": use the version of ParRay that wrote the state, or name another directory";
}

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

static std::string damage_text(const std::filesystem::path& directory,
                               const std::vector<std::string>& damage) {
  const std::string place = directory.string();
  const std::string more =
      damage.size() > 1 ? " (and " + std::to_string(damage.size() - 1) + " more)" : "";
  return place + ": the state is damaged: " + damage.front() + more +
         ": parray-coordinator --check " + place + " lists the damage, --repair " + place +
         " repairs it";
}

StateDamaged::StateDamaged(const std::filesystem::path& directory,
                           const std::vector<std::string>& damage)
    : RunError(damage_text(directory, damage)) {}

}  // namespace parray::store
