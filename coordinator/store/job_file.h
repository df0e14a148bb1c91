#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/store/job_record.h"
#include "coordinator/store/state_files.h"

/// The copies of the database's content that stand beside it, so that a lost database can be built
/// again. Each is JSON text that carries its own checksum:
///
///     {"checksum": "16 hexadecimal digits",
///     "content": {...}}
///
/// The checksum is the XXH3-64 of the bytes of `content`.
namespace parray::store {

/// The committed part of a rows file.
struct RowsFile {
  std::uint64_t number = 0;  ///< of the file, see StateFiles
  std::uint64_t bytes = 0;   ///< committed
  friend bool operator==(const RowsFile&, const RowsFile&) = default;
};

/// A picture's file.
struct KeptPicture {
  std::uint64_t number = 0;  ///< of the file, see StateFiles
  WholeFile file;
  friend bool operator==(const KeptPicture&, const KeptPicture&) = default;
};

/// Content of `jobs/ID/job.json`: everything that the database has about one job.
struct JobFile {
  std::uint64_t batch = 0;  ///< number of the commit that it belongs to
  std::string record{};     ///< record_to_json()
  /// At least so many bytes are committed: appending rows does not rewrite the file.
  std::optional<RowsFile> rows{};
  std::optional<KeptPicture> picture{};
};

/// Content of `notes.json`.
struct NotesFile {
  std::uint64_t batch = 0;  ///< number of the commit that it belongs to
  std::map<std::string, std::string> notes{};
};

std::string job_file_to_text(JobId id, const JobFile& file);
std::string notes_file_to_text(const NotesFile& file);

/// Inverses. Throw RunError that says what is wrong with the text.
JobFile job_file_from_text(JobId id, std::string_view text);
NotesFile notes_file_from_text(std::string_view text);

/// Number of completed commits as text of constant length with a checksum.
std::string commit_count_to_text(std::uint64_t commits);
/// Inverse. Nothing: the text is damaged.
std::optional<std::uint64_t> commit_count_from_text(std::string_view text);

}  // namespace parray::store
