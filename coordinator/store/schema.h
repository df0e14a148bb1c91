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

/// Prepares the database of a state directory for DiskStore: locks it for this process until
/// `database` is destroyed, and creates the tables of a new state.
///
///     jobs(id, scene, unfinished, record, batch)   record: record_to_json(); batch: see JobRow
///     scenes(digest, bytes, checksum)              size and XXH3-64 of the scene's file
///     pictures(job, number, bytes, checksum)       size and XXH3-64 of the file, see StateFiles
///     logs(job, number, bytes)                     committed bytes of the job's rows file
///     notes(name, text)
///
/// `found`: the small files beside the database (StateFiles): its copies and `commits`. Throws what
/// Database throws, and InputError for a state of another version. Throws StateDamaged in two
/// cases: the database has no tables, but `found` is not empty; or the tables have an earlier
/// version, but the file `commits` exists. States of earlier versions do not have this file.
void ready_database(Database& database, const StateFiles& files, const FoundFiles& found);

/// The message for tables of an earlier version in a state with the file `commits`.
inline constexpr const char* older_database =
    "parray.sqlite is of an earlier version than the other files of the state";

/// Returns the message for a state of another version, which this program cannot read.
std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version);

/// Creates the tables of the present version in an empty database.
void make_tables(Database& database);

/// Error: the state's database is damaged. parray-coordinator --check lists the damage, --repair
/// repairs it.
class StateDamaged : public RunError {
 public:
  /// `damage`: at least one line, one for each damage. The message has the first line and the
  /// number of further lines.
  StateDamaged(const std::filesystem::path& directory, const std::vector<std::string>& damage);
};

}  // namespace parray::store
