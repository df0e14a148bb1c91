#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/store/database.h"
#include "coordinator/store/job_record.h"
#include "coordinator/store/state_files.h"

/// The records of a state: the content of its database, and the files with copies of it, from which
/// --repair rebuilds a lost database. Each file is JSON text with its own checksum:
///
///     {"checksum": "16 hexadecimal digits",
///     "content": {...}}
///
/// The checksum is the XXH3-64 of the bytes of `content`.
namespace parray::store {

/// The committed part of a job's rows file, which holds its log of results.
struct RowsFile {
  std::uint64_t number = 0;  ///< of the file, see StateFiles
  std::uint64_t bytes = 0;   ///< committed bytes
  friend bool operator==(const RowsFile&, const RowsFile&) = default;
};

/// The file of a job's picture.
struct KeptPicture {
  std::uint64_t number = 0;  ///< of the file, see StateFiles
  WholeFile file;
  friend bool operator==(const KeptPicture&, const KeptPicture&) = default;
};

/// The content of `jobs/ID/job.json`: everything that the database has about one job.
struct JobFile {
  std::uint64_t batch = 0;  ///< number of the commit that wrote it
  std::string record{};     ///< text of record_to_json()
  /// `bytes` is a lower bound, because appending results does not rewrite job.json.
  std::optional<RowsFile> rows{};
  std::optional<KeptPicture> picture{};
};

/// The content of `notes.json`.
struct NotesFile {
  std::uint64_t batch = 0;  ///< number of the commit that wrote it
  std::map<std::string, std::string> notes{};
};

/// The database's content about one job.
struct JobRow {
  std::string scene{};                  ///< digest
  bool unfinished = false;              ///< the job needs its scene, see needs_scene()
  std::uint64_t batch = 0;              ///< number of the latest commit that wrote job.json
  std::optional<std::string> record{};  ///< text of record_to_json(); nothing: only files exist
  std::optional<RowsFile> rows{};
  std::optional<KeptPicture> picture{};
};

/// The complete content of a state's database.
struct Records {
  std::uint64_t batch = 0;  ///< number of the latest commit
  std::map<JobId, JobRow> jobs{};
  std::map<std::string, WholeFile> scenes{};  ///< by digest
  std::map<std::string, std::string> notes{};
  std::uint64_t notes_batch = 0;  ///< number of the latest commit that wrote notes.json
  std::string mark{};             ///< see Store; empty: none
  std::string reached{};          ///< see Store::reached_mark()
};

/// Version of the tables that this program reads and writes.
inline constexpr std::uint64_t present_version = 3;

/// The message for tables of an earlier version in a state with the file `commits`.
inline constexpr const char* older_database =
    "parray.sqlite is of an earlier version than the other files of the state";

/// Returns the message for a state of another version, which this program cannot read.
std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version);

/// Creates the tables of the present version in an empty database.
///
///     jobs(id, scene, unfinished, record, batch)   record: record_to_json(); batch: see JobRow
///     scenes(digest, bytes, checksum)              size and XXH3-64 of the scene's file
///     pictures(job, number, bytes, checksum)       size and XXH3-64 of the file, see StateFiles
///     logs(job, number, bytes)                     committed bytes of the job's rows file
///     notes(name, text)
void make_tables(Database& database);
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

/// Returns the text of job.json. Throws RunError if the record is not JSON.
std::string job_file_to_text(JobId id, const JobFile& file);
std::string notes_file_to_text(const NotesFile& file);

/// Reads the text of job.json. Throws RunError that describes what is wrong with the text.
JobFile job_file_from_text(JobId id, std::string_view text);
NotesFile notes_file_from_text(std::string_view text);  ///< throws RunError as job_file_from_text()

/// Returns the number of completed commits as text of constant length with a checksum.
std::string commit_count_to_text(std::uint64_t commits);
/// Reads the text of commit_count_to_text(). Returns nothing if the text is damaged.
std::optional<std::uint64_t> commit_count_from_text(std::string_view text);

}  // namespace parray::store
