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
/// A state of version 2 gets the copies beside the database (job_file.h). One of version 1, which
/// had everything in the database, is converted: finished jobs keep their pictures; unfinished
/// ones, whose rows have another form, are cancelled. Crashing or failing in it leaves the former
/// version. Returns whether it has converted.
///
/// `found`: the small files of the directory. Throws what Database throws, RunError for a state of
/// a later version, and StateDamaged for a database without tables beside files of jobs.
bool ready_database(Database& database, StateFiles& files, const FoundFiles& found);

/// Makes the tables of the present version in an empty database.
void make_tables(Database& database);

/// The state's database is not to be used before --repair.
class StateDamaged : public RunError {
 public:
  /// `damage`: a line each, at least one.
  StateDamaged(const std::filesystem::path& directory, const std::vector<std::string>& damage);
};

}  // namespace parray::store
