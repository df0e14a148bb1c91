#pragma once

#include "coordinator/store/database.h"
#include "coordinator/store/state_files.h"

namespace parray {

/// Readies the database of a state directory for DiskStore: its tables are those of the present
/// version when this returns, and it is this process's alone.
///
///     jobs(id, scene, unfinished, record)          record: record_to_json()
///     scenes(digest, bytes, checksum)              size and XXH3-64 of the scene's file
///     pictures(job, number, bytes, checksum)       likewise; number: see StateFiles
///     logs(job, number, bytes)                     committed bytes of the job's rows file
///     notes(name, text)
///
/// A state of version 1, which had everything in the database, is converted: finished jobs keep
/// their pictures; unfinished ones, whose rows have another form, are cancelled. Crashing or
/// failing in it leaves version 1.
///
/// Throws what Database throws, and RunError for a state of a later version.
void ready_database(Database& database, StateFiles& files);

}  // namespace parray
