#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/store/inspection.h"

namespace parray::store {

/// The content of a state's database.
struct DatabaseContent {
  bool present = false;       ///< the file exists
  std::uint64_t version = 0;  ///< of its tables; 0: it has none
  std::string damage{};       ///< why it cannot be read; empty: undamaged
  Records records{};          ///< empty unless the database is readable and of the present version
};

/// A damaged or missing file of a job.
struct FileDamage {
  enum class Kind : std::uint8_t { rows, picture, scene };
  JobId job = 0;
  Kind kind = Kind::rows;
  std::string line{};  ///< the message
};

/// Reads all results, pictures and scenes that the records name. Returns the damaged and missing
/// ones.
std::vector<FileDamage> verify_files(const StateFiles& files, const Records& records);

/// Returns whether the file has the `expected` size and checksum or, if that is null, the SHA-256
/// `digest`.
bool is_scene(const std::filesystem::path& file, const std::string& digest,
              const WholeFile* expected);

/// Everything that is known about a state.
struct Survey {
  DatabaseContent database;
  FoundFiles found;
  Comparison comparison;
  /// Damage of the database, or an unfinished backup; one line each. If there is any, only the
  /// copies are reliable.
  std::vector<std::string> severe;
  std::vector<Misplaced> misplaced{};  ///< paths that a repair must move away first
  bool is_backup = false;              ///< a new backup, which has no database yet
};

/// Examines a state. Throws InputError if `files` is no state or one of another version.
Survey survey_state(const StateFiles& files);

/// Rebuilds the database of a state and its copies, which are the files job.json and notes.json
/// (records.h). Takes each job and the notes either from the database or from the copy: from the
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
