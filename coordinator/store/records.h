#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/store/database.h"
#include "coordinator/store/job_file.h"

namespace parray::store {

/// What the database holds about one job.
struct JobRow {
  std::string scene{};  ///< digest
  bool unfinished = false;
  std::uint64_t batch = 0;              ///< commit that wrote job.json last
  std::optional<std::string> record{};  ///< record_to_json(); nothing: only files are kept
  std::optional<RowsFile> rows{};
  std::optional<KeptPicture> picture{};
};

/// Everything that the database of a state holds. See schema.h.
struct Records {
  std::uint64_t batch = 0;  ///< number of the latest commit
  std::map<JobId, JobRow> jobs{};
  std::map<std::string, WholeFile> scenes{};  ///< by digest
  std::map<std::string, std::string> notes{};
  std::uint64_t notes_batch = 0;  ///< commit that wrote notes.json last
  std::string mark{};             ///< see Store; empty: there is none
  std::string reached{};          ///< the latest mark that was kept, also when `mark` is empty
};

/// Reads all tables of the present version. Throws what Database throws.
Records read_records(Database& database);
/// Fills the empty tables of a database. Runs in the caller's transaction.
void write_records(Database& database, const Records& records);

/// Notes that the store keeps for itself: no note of a coordinator has such a name.
namespace own_note {
inline constexpr std::string_view mark = "mark";
inline constexpr std::string_view reached = "reached";
inline constexpr std::string_view batch = "commits";
inline constexpr std::string_view notes_batch = "notes commit";
}  // namespace own_note
/// Removes the store's own notes.
void erase_own_notes(std::map<std::string, std::string>& notes);

/// Each writes, or with nothing removes, one row.
void write_note(Database& database, std::string_view name, const std::string& text);
void write_scene(Database& database, const std::string& digest,
                 const std::optional<WholeFile>& file);
void write_rows(Database& database, JobId job, const std::optional<RowsFile>& rows);
void write_picture(Database& database, JobId job, const std::optional<KeptPicture>& picture);

}  // namespace parray::store
