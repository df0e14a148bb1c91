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

/// Readies the database of a state directory for DiskStore: its tables are those of the present
/// version when this returns, and it is this process's alone.
///
///     jobs(id, scene, unfinished, record, batch)   record: record_to_json(); batch: see JobRow
///     scenes(digest, bytes, checksum)              size and XXH3-64 of the scene's file
///     pictures(job, number, bytes, checksum)       likewise; number: see StateFiles
///     logs(job, number, bytes)                     committed bytes of the job's rows file
///     notes(name, text)
///
/// `found`: the small files of the directory. Throws what Database throws, InputError for a state
/// of another version, and StateDamaged for a database without tables beside files of jobs.
void ready_database(Database& database, const StateFiles& files, const FoundFiles& found);

/// The damage of a database whose version is lower than that of the files beside it.
inline constexpr const char* older_database = "the database is of an earlier version than the jobs";

/// Returns the message for a state of another version, which this program cannot read.
std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version);

/// Makes the tables of the present version in an empty database.
void make_tables(Database& database);

/// The state's database is not to be used before --repair.
class StateDamaged : public RunError {
 public:
  /// `damage`: a line each, at least one.
  StateDamaged(const std::filesystem::path& directory, const std::vector<std::string>& damage);
};

}  // namespace parray::store
