#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/records.h"

/// Compares the database of a state with the small files beside it, which are copies of its content
/// (records.h).
///
/// A commit writes `job.next`, then commits the database, and only then renames `job.next` to
/// `job.json`. So after a crash `job.next` may be newer than the database, but `job.json` never is:
/// a newer `job.json` proves that the database has lost commits. The file `commits` proves the
/// same for commits that wrote no job.json. A commit that drops a job renames `job.json` to
/// `job.dropped` before it commits the database.
namespace parray::store {

/// The small files of one job.
struct FoundJob {
  std::optional<JobFile> json{};
  std::optional<JobFile> next{};
  std::optional<JobFile> dropped{};
  std::string problem{};  ///< why an existing job.json cannot be read; empty: it can, or is missing
};

/// The small files of a state.
struct FoundFiles {
  std::map<JobId, FoundJob> jobs{};  ///< the jobs that have a directory
  std::optional<NotesFile> notes{};
  std::optional<NotesFile> notes_next{};
  bool has_commits = false;
  std::optional<std::uint64_t> commits{};  ///< content of `commits`; nothing: missing or damaged
  bool incomplete = false;  ///< the file `incomplete` exists: this backup was not finished

  /// Returns whether the directory has no trace of a commit.
  [[nodiscard]] bool empty() const { return jobs.empty() && !has_commits && !notes; }
};

/// The message for an unfinished backup.
inline constexpr std::string_view unfinished_copy =
    "this copy was not finished, and jobs may be missing from it: make the backup again";

/// Reads all small files. Changes nothing. Does not throw for damaged files. A coordinator may be
/// writing at the same time, so the order of reading matters. `next` comes before `json`: if a
/// commit renames `next` in between, `json` has its content. The number of commits comes last: it
/// then counts every commit that was complete when its `next` was read.
FoundFiles find_files(const StateFiles& files);
FoundJob find_job(const StateFiles& files, JobId id);  ///< reads only the files of one job
FoundFiles find_notes(const StateFiles& files);        ///< reads only the files outside jobs/

/// The changes of small files that opening the state has to make.
struct Upkeep {
  std::vector<JobId> finish{};          ///< rename job.next to job.json: its commit was completed
  std::vector<JobId> remove_next{};     ///< remove job.next: its commit was not completed
  std::vector<JobId> restore{};         ///< rename job.dropped to job.json: the job still exists
  std::vector<JobId> remove_dropped{};  ///< remove job.dropped and the files that it names
  std::vector<JobId> rewrite{};         ///< write job.json again from the database
  bool finish_notes = false;            ///< rename notes.next to notes.json
  bool rewrite_notes = false;           ///< write notes.json again from the database
};

/// The differences between database and copies.
struct Comparison {
  /// Damage of the database, one line each: it has lost commits or holds wrong values. If there is
  /// any, only --repair may use the database.
  std::vector<std::string> severe{};
  /// Damage of copies that opening repairs from the database, one line each.
  std::vector<std::string> minor{};
  Upkeep upkeep{};
};

/// Compares database and small files. File names in the lines are relative to the state.
Comparison compare(const Records& records, const FoundFiles& found);

/// Returns whether `scene` and `unfinished` of the row agree with its record.
bool row_matches_record(const JobRow& row);
/// Sets `scene` and `unfinished` of the row from its record. Throws RunError for a damaged record.
void complete_row(JobId id, JobRow& row);

/// A path of the state that holds the wrong kind of thing: a directory, a pipe, a socket or a
/// device in the place of a file, or a file in the place of a directory.
struct Misplaced {
  std::filesystem::path path{};  ///< absolute
  std::string line{};  ///< "jobs/3/rows is a directory, not a file", relative to the state
};

/// Finds misplaced paths among the names that the state uses, directories before their content. A
/// symbolic link counts as its target. Opens and changes no file.
std::vector<Misplaced> find_misplaced(const StateFiles& files);

/// Moves each path to lost/`uptime`. Returns one line for each. Throws RunError if it cannot move
/// one.
std::vector<std::string> move_misplaced_to_lost(StateFiles& files,
                                                const std::vector<Misplaced>& misplaced,
                                                std::uint64_t uptime);

}  // namespace parray::store
