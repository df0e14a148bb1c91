#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/store/survey.h"

namespace parray::store {

/// Rebuilds the database of a state and all copies from whichever of both is newer and undamaged.
/// Moves damaged files except scenes to lost/. Returns one line for each job that was taken from a
/// copy, changed or lost. `now`: seconds since 1970. Throws RunError if it cannot write; the caller
/// may repeat the call.
std::vector<std::string> rebuild_state(StateFiles& files, const Survey& survey, double now);

/// Returns the notes of the latest commit; nothing: the state has none. A coordinator may be
/// writing at the same time.
std::optional<NotesFile> committed_notes(const StateFiles& files);

/// Copies the small files, results, pictures and scenes of a state, but not the database. A
/// coordinator may be serving the state. Returns one line for each missing or damaged file. Throws
/// RunError if it cannot write, InputError if the source has jobs but no file `commits`.
std::vector<std::string> copy_state(const StateFiles& from, StateFiles& onto);

}  // namespace parray::store
