#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/rooms.h"

/// What an administrator does with the state of a coordinator from outside: see FARM.md. Every line
/// is one sentence for a terminal.
namespace parray::store {

/// Reads the whole state: database, copies, rows, pictures and scenes. Returns one line for each
/// damage; what a crash leaves behind is none. Changes nothing.
///
/// Throws InputError when the directory holds no state, or one of another version; StateInUse
/// when a coordinator serves it.
std::vector<std::string> find_damage(const std::filesystem::path& directory);

/// Makes the state whole again: builds the database from its copies, cuts rows after the last sound
/// entry, and marks jobs as failed whose picture or scene is damaged. Damaged files move to lost/,
/// and so does a directory or a pipe in the place of a file.
/// Returns a line for each damage, each loss and each thing done; none: there was no damage.
/// `now`: seconds since 1970. Throws what find_damage() throws, and RunError when it cannot write.
std::vector<std::string> repair_state(const std::filesystem::path& directory, double now);

/// Copies a state, which a coordinator may be serving, to a directory that is empty or does not
/// exist. The copy contains every job that was acknowledged before the call. Returns a line for
/// each damage that it found and left out. Throws InputError when the target is not empty or cannot
/// be written, or the source is no state, or is a standby's that its primary is filling up. A copy
/// that fails is removed. One that is killed holds the file `incomplete`.
std::vector<std::string> back_up_state(const std::filesystem::path& directory,
                                       const std::filesystem::path& target, double now);

}  // namespace parray::store
