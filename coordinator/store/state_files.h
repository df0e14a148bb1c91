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
#include "coordinator/store/whole_file.h"

namespace parray::store {

/// The plain files below a state directory:
///
///     scenes/DIGEST
///     jobs/ID/rows      jobs/ID/rows.1 ...      the number tells a file from one that it replaces
///     jobs/ID/picture   jobs/ID/picture.1 ...   and that stays until the change is committed
///     jobs/ID/job.json   notes.json             copies of what the database holds, see job_file.h
///     jobs/ID/job.next   notes.next             the same, of a commit under way
///     jobs/ID/job.dropped                       job.json of a job that is being dropped
///     commits                                   number of completed commits
///     lost/SECONDS/...                          files that no record names; SECONDS: uptime
///     reserve                                   room to give up, so that a full disk can be
///                                               cleared
///
/// Which of them count, and how many bytes of a rows file, stands in the database. What is written
/// here is on the disk when the function returns, except names of new files and what overwrite()
/// writes: those wait for sync().
///
/// Errors: StorageFull that names the directory when the disk does not take what is written, else
/// RunError that names the file. One thread.
class StateFiles {
 public:
  /// Makes the directory if need be; InputError when that cannot be done.
  StateFiles(const std::filesystem::path& directory, Disk& disk);

  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  /// Throws std::logic_error unless `digest` is 64 lower-case hexadecimal digits: it becomes a
  /// name.
  [[nodiscard]] std::filesystem::path scene(const std::string& digest) const;
  [[nodiscard]] std::filesystem::path job(JobId job) const;  ///< the directory
  [[nodiscard]] std::filesystem::path rows(JobId job, std::uint64_t number) const;
  [[nodiscard]] std::filesystem::path picture(JobId job, std::uint64_t number) const;
  [[nodiscard]] std::filesystem::path job_json(JobId job) const;
  [[nodiscard]] std::filesystem::path job_next(JobId job) const;
  [[nodiscard]] std::filesystem::path job_dropped(JobId job) const;
  [[nodiscard]] std::filesystem::path notes_json() const { return directory_ / "notes.json"; }
  [[nodiscard]] std::filesystem::path notes_next() const { return directory_ / "notes.next"; }
  [[nodiscard]] std::filesystem::path commits() const { return directory_ / "commits"; }
  /// Stands in a copy until --backup has finished it.
  [[nodiscard]] std::filesystem::path incomplete() const { return directory_ / "incomplete"; }
  [[nodiscard]] std::filesystem::path database() const { return directory_ / "parray.sqlite"; }
  [[nodiscard]] std::filesystem::path lost() const { return directory_ / "lost"; }
  [[nodiscard]] std::filesystem::path reserve() const { return directory_ / "reserve"; }
  [[nodiscard]] std::filesystem::path scenes() const { return directory_ / "scenes"; }
  [[nodiscard]] std::filesystem::path jobs() const { return directory_ / "jobs"; }
  /// Where write() puts the bytes of `file` before it renames them to `file`.
  [[nodiscard]] static std::filesystem::path temporary(const std::filesystem::path& file);
  /// Whether the state keeps files of that name in scenes/ or jobs/ID/. Temporary files count.
  [[nodiscard]] static bool is_file_name(std::string_view name);
  /// Jobs that have a directory, ascending.
  [[nodiscard]] std::vector<JobId> jobs_with_directory() const;

  /// Makes the file of the pieces, one after the other; its directory, too, if need be. A file of
  /// that name is replaced. All or nothing.
  WholeFile write(const std::filesystem::path& file, std::span<const std::string_view> pieces);

  /// Writes to the file from `offset` on; the file and its directory are made if need be. After a
  /// failure, or a crash, what lies beyond `offset` is undefined.
  void write_at(const std::filesystem::path& file, std::uint64_t offset,
                std::span<const std::string_view> pieces);

  /// Writes a small file in place of what it held. sync() makes it durable. After a failure, also
  /// of sync(), or a crash, its content is undefined: for files that carry a checksum.
  void overwrite(const std::filesystem::path& file, std::string_view bytes);
  /// The same, not durable: the system writes the bytes when it likes. Ignores failures.
  void overwrite_later(const std::filesystem::path& file, std::string_view bytes);
  /// Renames a file, in place of one of that name. The new name is not durable: for that, call
  /// expect_sync() before sync().
  void rename(const std::filesystem::path& from, const std::filesystem::path& onto);

  /// The next sync() makes the names in this directory durable.
  void expect_sync(const std::filesystem::path& directory) { unsynced_.insert(directory); }

  /// Makes durable what overwrite() has written, and the names of new files. Takes one call of the
  /// system for each file and directory, but only one for all of them where they are many: a
  /// thousand calls take seconds. After a failure it has everything left to do.
  void sync();

  /// The whole file. Throws DamagedFile when it is not as `expected`, RunError when it cannot be
  /// opened for another reason.
  [[nodiscard]] static std::string read(const std::filesystem::path& file,
                                        const WholeFile& expected);

  /// Makes the reserve unless it is there or there is no room for it.
  void keep_reserve();
  bool release_reserve();  ///< removes it; false: there is none

  /// Removes a file or an empty directory, if it can.
  static void remove(const std::filesystem::path& path);

  /// Gives back what a crash has left behind the first `bytes` bytes of the file, if it can.
  static void cut(const std::filesystem::path& file, std::uint64_t bytes);

  /// Removes temporary files. Moves files of the kinds above that are not in `named` to
  /// lost/`uptime`, and returns their former paths. Other files stay: they belong to somebody
  /// else.
  std::vector<std::filesystem::path> set_aside_unnamed(const std::set<std::filesystem::path>& named,
                                                       std::uint64_t uptime);
  /// Moves one file to lost/`uptime`; false: it cannot be moved and stays.
  bool set_aside(const std::filesystem::path& file, std::uint64_t uptime);
  /// Bytes of the files below lost/.
  [[nodiscard]] std::uint64_t lost_bytes() const;
  /// Removes what was moved to lost/ before an uptime of `uptime` seconds.
  void remove_lost(double uptime) const;

 private:
  void make_directory(const std::filesystem::path& directory);
  void put_all(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
               const std::filesystem::path& path);
  void write_all(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
                 const std::filesystem::path& path);
  void sync_written(const std::filesystem::path& file);
  [[noreturn]] void fail(const std::filesystem::path& file, int error) const;
  void set_aside_unnamed_in(const std::filesystem::path& directory,
                            const std::set<std::filesystem::path>& named, std::uint64_t uptime,
                            std::vector<std::filesystem::path>& moved);

  std::filesystem::path directory_;
  Disk& disk_;
  bool reserved_ = false;  ///< the reserve is there
  /// Names the file system to sync. Open for as long as this lives: the system reports only the
  /// failures since then.
  std::shared_ptr<const int> file_system_;
  std::set<std::filesystem::path> written_;   ///< files that overwrite() has written
  std::set<std::filesystem::path> unsynced_;  ///< directories with new names in them
};

/// The whole file; nothing: it cannot be read. For small files.
std::optional<std::string> text_of_file(const std::filesystem::path& file);

/// Absolute and without a slash at its end, so that paths below it compare equal.
std::filesystem::path normal_directory(const std::filesystem::path& directory);

}  // namespace parray::store
