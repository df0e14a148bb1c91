#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

/// The tools of an administrator for the state of a coordinator: see FARM.md. Each returned line is
/// one sentence for a terminal.
namespace parray::store {

/// Reads the whole state: database, copies, results, pictures and scenes. Returns one line for each
/// damage. Leftovers of a crash are no damage. Changes nothing.
///
/// Does not read results, pictures and scenes if the database is damaged. Throws InputError if the
/// directory has no state or one of another version; StateInUse if another process uses it;
/// RunError if there is no room for a temporary copy of the database.
std::vector<std::string> find_damage(const std::filesystem::path& directory);

/// Repairs a damaged state; changes nothing if there is no damage. Rebuilds the database from its
/// undamaged content and from its copies. Keeps the undamaged results at the beginning of each log.
/// Jobs fail if their picture is damaged. Jobs that are not done fail also if their scene is
/// damaged; those that are done only lose denoising and labels.
///
/// Moves to lost/ the former database, damaged files except scenes, the directories of lost jobs,
/// and directories or pipes in the place of a file. Returns one line for each damage, loss and
/// repair; none: there was no damage. `now`: seconds since 1970, for the events of jobs that
/// change. Throws what find_damage() throws, and RunError if it cannot write.
std::vector<std::string> repair_state(const std::filesystem::path& directory, double now);

/// Copies a state to a directory that is empty or does not exist. A coordinator may be serving the
/// state. The copy contains every job that was acknowledged before the call. Returns one line for
/// each missing or damaged file. The copy lacks these files; of damaged results it has the part
/// before the damage. Throws InputError if the target is not empty or lies in the state, if the
/// source is no state or a standby during a full copy, or if copying fails. Removes the copy after
/// a failure. If the process is killed, the copy contains the file `incomplete`. `now`: seconds
/// since 1970, for the events of jobs that change.
std::vector<std::string> back_up_state(const std::filesystem::path& directory,
                                       const std::filesystem::path& target, double now);

/// The options --check, --repair and --backup of parray-coordinator. Each prints the lines of one
/// of the functions above to standard output, returns the exit status, and throws what that
/// function throws.
int check_command(const std::string& directory);  ///< returns 1 if the state is damaged
int repair_command(const std::string& directory, double now);  ///< returns 0
/// Returns 1 if the copy lacks damaged files. `places`: the state's directory and the target.
int backup_command(const std::vector<std::string>& places, double now);

}  // namespace parray::store
