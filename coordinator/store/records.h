#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/store/database.h"
#include "coordinator/store/job_file.h"

namespace parray::store {

/// The database's content about one job.
struct JobRow {
  std::string scene{};                  ///< digest
  bool unfinished = false;              ///< the job needs its scene, see needs_scene()
  std::uint64_t batch = 0;              ///< number of the latest commit that wrote job.json
  std::optional<std::string> record{};  ///< text of record_to_json(); nothing: only files exist
  std::optional<RowsFile> rows{};
  std::optional<KeptPicture> picture{};
};

/// The complete content of a state's database. See schema.h.
struct Records {
  std::uint64_t batch = 0;  ///< number of the latest commit
  std::map<JobId, JobRow> jobs{};
  std::map<std::string, WholeFile> scenes{};  ///< by digest
  std::map<std::string, std::string> notes{};
  std::uint64_t notes_batch = 0;  ///< number of the latest commit that wrote notes.json
  std::string mark{};             ///< see Store; empty: none
  std::string reached{};          ///< see Store::reached_mark()
};

/// Reads all tables of the present version. Throws what Database throws.
Records read_records(Database& database);
/// Fills the empty tables of a database, in the caller's transaction. Does not write the mark.
void write_records(Database& database, const Records& records);

/// Names of notes that only the store uses.
namespace own_note {
inline constexpr std::string_view mark = "mark";
inline constexpr std::string_view reached = "reached";
inline constexpr std::string_view batch = "commits";
inline constexpr std::string_view notes_batch = "notes commit";
}  // namespace own_note
void erase_own_notes(std::map<std::string, std::string>& notes);  ///< removes those notes

// Each of these writes one row of a table; a missing value removes the row.
void write_note(Database& database, std::string_view name, const std::string& text);
void write_scene(Database& database, const std::string& digest,
                 const std::optional<WholeFile>& file);
void write_rows(Database& database, JobId job, const std::optional<RowsFile>& rows);
void write_picture(Database& database, JobId job, const std::optional<KeptPicture>& picture);

}  // namespace parray::store
