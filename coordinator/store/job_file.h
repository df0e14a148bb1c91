#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/store/job_record.h"
#include "coordinator/store/state_files.h"

/// The files with copies of the database's content, from which --repair rebuilds a lost database.
/// Each is JSON text with its own checksum:
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
