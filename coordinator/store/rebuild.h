#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/store/survey.h"

namespace parray::store {

/// Writes a state's database and its copies anew, from what of both is to be believed, and sets
/// damaged files aside. Returns a line for each job that was taken from a copy, or changed, or
/// lost. `now`: seconds since 1970. Throws RunError when it cannot write; it can be called again
/// then.
std::vector<std::string> rebuild_state(StateFiles& files, const Survey& survey, double now);

/// The notes of the last commit, read beside a coordinator that may be serving; nothing: none are
/// kept.
std::optional<NotesFile> committed_notes(const StateFiles& files);

/// Copies the small files, rows, pictures and scenes of a state that a coordinator may be serving.
/// The database is not copied. Returns a line for each file that is missing or damaged. Throws
/// RunError when it cannot write, InputError when the source has no job.json.
std::vector<std::string> copy_state(const StateFiles& from, StateFiles& onto);

}  // namespace parray::store
