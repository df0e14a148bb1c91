#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/job_file.h"
#include "coordinator/store/records.h"
#include "coordinator/store/state_files.h"

/// Compares the database of a state with the copies beside it (job_file.h).
///
/// A commit writes `job.next`, then commits the database, and only then renames `job.next` to
/// `job.json`. So after a crash `job.next` may be newer than the database, but `job.json` never is:
/// a newer `job.json` proves that the database has lost commits. The file `commits` proves the
/// same for commits that wrote no job.json.
namespace parray::store {

/// The small files of one job.
struct FoundJob {
  std::optional<JobFile> json{};
  std::optional<JobFile> next{};
  std::optional<JobFile> dropped{};
  std::string trouble{};  ///< why job.json, which is there, cannot be read; empty: nothing
};

/// The small files of a state.
struct FoundFiles {
  std::map<JobId, FoundJob> jobs{};  ///< those with a directory
  std::optional<NotesFile> notes{};
  std::optional<NotesFile> notes_next{};
  bool has_commits = false;
  std::optional<std::uint64_t> commits{};  ///< nothing: the file is missing or damaged
  bool incomplete = false;                 ///< a backup that was not finished

  /// Nothing was ever committed here.
  [[nodiscard]] bool fresh() const { return jobs.empty() && !has_commits && !notes; }
};

/// What is wrong with a backup that was not finished.
inline constexpr std::string_view unfinished_copy =
    "this copy was not finished, and jobs may be missing from it: make the backup again";

/// Reads them. Changes nothing. A coordinator may be writing: `next` is read before `json`, and the
/// number of commits last, so that nothing acknowledged is missed.
FoundFiles find_files(const StateFiles& files);
/// The same of one job, and of everything but jobs.
FoundJob find_job(const StateFiles& files, JobId id);
FoundFiles find_notes(const StateFiles& files);

/// What opening the state has to do to the small files.
struct Upkeep {
  std::vector<JobId> finish{};          ///< rename job.next to job.json: its commit is done
  std::vector<JobId> remove_next{};     ///< its commit never was
  std::vector<JobId> restore{};         ///< rename job.dropped to job.json: the drop never was
  std::vector<JobId> remove_dropped{};  ///< the files of a dropped job are yet to go
  std::vector<JobId> rewrite{};         ///< job.json, from the database
  bool postprocessing_notes = false;
  bool rewrite_notes = false;
};

struct Comparison {
  /// Damage of the database, a line each: it has lost commits or holds wrong values. It must not be
  /// used before --repair.
  std::vector<std::string> grave{};
  /// Damage of copies that the database makes good, a line each.
  std::vector<std::string> minor{};
  Upkeep upkeep{};
};

/// The names in the lines are relative to the state's directory.
Comparison compare(const Records& records, const FoundFiles& found);

/// Whether scene and `unfinished` of the row are those of its record.
bool row_matches_record(const JobRow& row);
/// Sets scene and `unfinished` of the row from its record. Throws RunError: it is none.
void complete_row(JobId id, JobRow& row);

}  // namespace parray::store
