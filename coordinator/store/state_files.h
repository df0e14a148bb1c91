#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/disk.h"
#include "coordinator/store/job_record.h"

namespace parray::store {

/// The plain files below a state directory:
///
///     scenes/DIGEST
///     jobs/ID/rows      jobs/ID/rows.1 ...      log of results
///     jobs/ID/picture   jobs/ID/picture.1 ...   finished picture
///     jobs/ID/job.json   notes.json             copies of the database's content, see records.h
///     jobs/ID/job.next   notes.next             copies written by an unfinished commit
///     jobs/ID/job.dropped                       job.json of a job that is being dropped
///     commits                                   number of completed commits
///     lost/SECONDS/...                          set aside, not deleted; SECONDS: farm's uptime
///     reserve                                   room that a commit on a full disk can use
///
/// A new log or picture has another number than the file that it replaces at the commit. The
/// database defines which files count, and how many bytes of a log count. Each function returns
/// when the data is on the disk. Only names of new files and the data of overwrite() wait for
/// sync(), and overwrite_later() promises nothing.
///
/// Errors: StorageFull that names the directory if the disk does not accept the data or the
/// directory is not writable, otherwise RunError that names the file. Not thread-safe.
class StateFiles {
 public:
  /// Creates the directory if necessary. Throws InputError if that fails.
  StateFiles(const std::filesystem::path& directory, Disk& disk);

  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  /// Throws std::logic_error unless `digest` is 64 lower-case hexadecimal digits.
  [[nodiscard]] std::filesystem::path scene(const std::string& digest) const;
  [[nodiscard]] std::filesystem::path job(JobId id) const {  ///< the directory
    return jobs() / std::to_string(id);
  }
  [[nodiscard]] std::filesystem::path rows(JobId job, std::uint64_t number) const;
  [[nodiscard]] std::filesystem::path picture(JobId job, std::uint64_t number) const;
  [[nodiscard]] std::filesystem::path job_json(JobId id) const { return job(id) / "job.json"; }
  [[nodiscard]] std::filesystem::path job_next(JobId id) const { return job(id) / "job.next"; }
  [[nodiscard]] std::filesystem::path job_dropped(JobId id) const {
    return job(id) / "job.dropped";
  }
  [[nodiscard]] std::filesystem::path notes_json() const { return directory_ / "notes.json"; }
  [[nodiscard]] std::filesystem::path notes_next() const { return directory_ / "notes.next"; }
  [[nodiscard]] std::filesystem::path commits() const { return directory_ / "commits"; }
  /// A file that exists in a backup until --backup has finished.
  [[nodiscard]] std::filesystem::path incomplete() const { return directory_ / "incomplete"; }
  [[nodiscard]] std::filesystem::path database() const { return directory_ / "parray.sqlite"; }
  [[nodiscard]] std::filesystem::path lost() const { return directory_ / "lost"; }
  [[nodiscard]] std::filesystem::path reserve() const { return directory_ / "reserve"; }
  [[nodiscard]] std::filesystem::path scenes() const { return directory_ / "scenes"; }
  [[nodiscard]] std::filesystem::path jobs() const { return directory_ / "jobs"; }
  /// Returns the path to which write() writes before it renames that path to `file`.
  [[nodiscard]] static std::filesystem::path temporary(const std::filesystem::path& file);
  /// Returns whether files in scenes/ or jobs/ID/ can have this name, including temporary files.
  [[nodiscard]] static bool is_file_name(std::string_view name);
  /// Returns the jobs that have a directory, in ascending order.
  [[nodiscard]] std::vector<JobId> jobs_with_directory() const;

  /// Creates or replaces a file that consists of the pieces in order. Creates its directory if
  /// necessary. Changes nothing if it fails.
  WholeFile write(const std::filesystem::path& file, std::span<const std::string_view> pieces);
  WholeFile write(const std::filesystem::path& file, std::string_view bytes) {
    return write(file, std::span(&bytes, 1));
  }

  /// Writes the pieces to the file from `offset` on. Creates the file if necessary. At offset 0,
  /// also creates its directory. After a failure or crash, the content beyond `offset` is
  /// undefined.
  void write_at(const std::filesystem::path& file, std::uint64_t offset,
                std::span<const std::string_view> pieces);

  /// Replaces the content of a small file, which sync() makes durable. After a failure of this
  /// function or sync(), or a crash, the content is undefined. Use it for files with a checksum.
  void overwrite(const std::filesystem::path& file, std::string_view bytes);
  /// Replaces the content of an existing file without making it durable. Ignores failures.
  void overwrite_later(const std::filesystem::path& file, std::string_view bytes);
  /// Renames a file and replaces `onto`. To make the new name durable, call expect_sync() and then
  /// sync().
  void rename(const std::filesystem::path& from, const std::filesystem::path& onto);

  /// Makes the next sync() save the names in this directory.
  void expect_sync(const std::filesystem::path& directory) { unsynced_.insert(directory); }

  /// Makes the data of overwrite() and the names of new files durable. Up to 16 files and
  /// directories take one system call each; more take a single call, because a thousand calls take
  /// seconds. After a failure, the next sync() does what is left.
  void sync();

  /// Returns the content of the file. Throws DamagedFile if it is missing or differs from
  /// `expected`, RunError if it cannot be opened.
  [[nodiscard]] static std::string read(const std::filesystem::path& file,
                                        const WholeFile& expected);

  /// Creates the reserve if it does not exist and there is room for it.
  void keep_reserve();
  bool release_reserve();  ///< removes the reserve; returns false if there is none

  /// Removes a file or an empty directory. Ignores failures.
  static void remove(const std::filesystem::path& path);

  /// Cuts the file after its first `bytes` bytes. Ignores failures.
  static void cut(const std::filesystem::path& file, std::uint64_t bytes);

  /// Removes temporary files and empty directories of jobs. Moves files of the kinds above that are
  /// not in `named` to lost/`uptime`, and returns their former paths. Leaves other files alone.
  std::vector<std::filesystem::path> move_unnamed_to_lost(
      const std::set<std::filesystem::path>& named, std::uint64_t uptime);
  /// Moves one file to lost/`uptime`. Returns false if that fails.
  bool move_to_lost(const std::filesystem::path& file, std::uint64_t uptime);
  /// Returns the size in bytes of all files below lost/.
  [[nodiscard]] std::uint64_t lost_bytes() const;
  /// Removes files that moved to lost/ before an uptime of `uptime` seconds.
  void remove_lost(double uptime) const;

 private:
  void make_directory(const std::filesystem::path& directory);
  void write_and_sync(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
                      const std::filesystem::path& path);
  void write_all(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
                 const std::filesystem::path& path);
  [[noreturn]] void fail(const std::filesystem::path& file, int error) const;
  void move_unnamed_in_to_lost(const std::filesystem::path& directory,
                               const std::set<std::filesystem::path>& named, std::uint64_t uptime,
                               std::vector<std::filesystem::path>& moved);

  std::filesystem::path directory_;
  Disk& disk_;
  bool reserved_ = false;  ///< the reserve exists
  /// Descriptor of the file system to sync. It stays open, because the system reports only failures
  /// since the opening.
  std::shared_ptr<const OpenPath> file_system_;
  std::set<std::filesystem::path> written_;   ///< files of overwrite() that were not synced
  std::set<std::filesystem::path> unsynced_;  ///< directories with new names
};

/// Returns the absolute path without a slash at its end, so that paths below it compare equal.
std::filesystem::path normal_directory(const std::filesystem::path& directory);

}  // namespace parray::store
