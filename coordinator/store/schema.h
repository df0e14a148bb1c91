#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "coordinator/store/database.h"
#include "coordinator/store/inspection.h"
#include "coordinator/store/state_files.h"

namespace parray::store {

/// Version of the tables that this program reads and writes.
inline constexpr std::uint64_t present_version = 3;

/// Prepares the database of a state directory for DiskStore: locks it for this process and creates
/// the tables if it has none.
///
///     jobs(id, scene, unfinished, record, batch)   record: record_to_json(); batch: see JobRow
///     scenes(digest, bytes, checksum)              size and XXH3-64 of the scene's file
///     pictures(job, number, bytes, checksum)       size and XXH3-64 of the file, see StateFiles
///     logs(job, number, bytes)                     committed bytes of the job's rows file
///     notes(name, text)
///
/// `found`: the small files of the directory. Throws what Database throws; InputError for a state
/// of another version; StateDamaged if the database lacks tables or is older than the small files.
void ready_database(Database& database, const StateFiles& files, const FoundFiles& found);

/// The message for a database whose version is lower than that of the small files.
inline constexpr const char* older_database = "the database is of an earlier version than the jobs";

/// Returns the message for a state of another version, which this program cannot read.
std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version);

/// Creates the tables of the present version in an empty database.
void make_tables(Database& database);

/// The state's database is damaged, and only --repair may use it.
class StateDamaged : public RunError {
 public:
  /// `damage`: at least one line, one for each damage.
  StateDamaged(const std::filesystem::path& directory, const std::vector<std::string>& damage);
};

}  // namespace parray::store
