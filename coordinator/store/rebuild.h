#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/store/survey.h"

namespace parray::store {

/// Rebuilds the database of a state and its copies, which are the files job.json and notes.json
/// (job_file.h). Takes each job and the notes either from the database or from the copy: from the
/// newer one that is undamaged. `survey` describes `files`. `now`: seconds since 1970, for the
/// events of jobs that change.
///
/// Moves to lost/ the former database, damaged results and pictures, the directories of lost jobs,
/// and Survey::misplaced. Damaged results keep their undamaged beginning. Damaged scenes stay.
///
/// Returns one line for each misplaced path, for each damaged file of results, picture or scene,
/// and for each job that is left out or lost. If the database is damaged and the state is no
/// backup, adds a line for each job that is restored from its copy or has results that may be
/// incomplete. Throws RunError if it cannot write; the caller may repeat the call.
std::vector<std::string> rebuild_state(StateFiles& files, const Survey& survey, double now);

/// Returns the notes of the latest commit; nothing: the state has none. A coordinator may be
/// writing at the same time.
std::optional<NotesFile> committed_notes(const StateFiles& files);

/// Copies notes.json and, of each committed job, job.json, the results, the picture, and the scene
/// if the job still needs it (JobRow::unfinished). Copies no database: call rebuild_state() for
/// `onto` afterwards. Cuts the results after their last undamaged entry. Does not check pictures
/// and scenes. A coordinator may be serving the state.
///
/// Returns one line for each job that it leaves out, because job.json is damaged, and for each
/// other job without its results or picture. Throws RunError if it cannot write, InputError if the
/// source has jobs but no file `commits`.
std::vector<std::string> copy_state(const StateFiles& from, StateFiles& onto);

}  // namespace parray::store
