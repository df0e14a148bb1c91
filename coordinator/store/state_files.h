#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "coordinator/store/disk.h"
#include "coordinator/store/job_record.h"

namespace parray {

/// Size and XXH3-64 of a file that is written once and never changed.
struct WholeFile {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
};

/// The plain files below a state directory:
///
///     scenes/DIGEST
///     jobs/ID/rows      jobs/ID/rows.1 ...      the number tells a file from one that it replaces
///     jobs/ID/picture   jobs/ID/picture.1 ...   and that stays until the change is committed
///     reserve                                   room to give up, so that a full disk can be
///     cleared
///
/// Which of them count, and how many bytes of a rows file, stands in the database. What is written
/// here is on the disk when the function returns, but for the names of new files: those wait for
/// sync_directories().
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

  /// Makes the file of the pieces, one after the other; its directory, too, if need be. A file of
  /// that name is replaced. All or nothing.
  WholeFile write(const std::filesystem::path& file, std::span<const std::string_view> pieces);

  /// Writes to the file from `offset` on; the file and its directory are made if need be. After a
  /// failure, or a crash, what lies beyond `offset` is undefined.
  void write_at(const std::filesystem::path& file, std::uint64_t offset,
                std::span<const std::string_view> pieces);

  /// Makes the names of new files durable, too. Failing, it has everything left to do.
  void sync_directories();

  /// The whole file. Throws RunError when it is not as `expected`.
  [[nodiscard]] static std::string read(const std::filesystem::path& file,
                                        const WholeFile& expected);

  /// Makes the reserve unless it is there or there is no room for it.
  void keep_reserve();
  bool release_reserve();  ///< removes it; false: there is none

  /// Gives back what a crash has left behind the first `bytes` bytes of the file, if it can.
  static void cut(const std::filesystem::path& file, std::uint64_t bytes);

  /// Removes what a crash has left: files and directories of the kinds above, and temporary ones,
  /// that are not in `named`. Anything else that lies here is somebody else's and stays.
  void remove_leftovers(const std::set<std::filesystem::path>& named) const;

 private:
  void make_directory(const std::filesystem::path& directory);
  void put_all(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
               const std::filesystem::path& path);
  [[noreturn]] void fail(const std::filesystem::path& file, int error) const;

  std::filesystem::path directory_;
  Disk& disk_;
  bool reserved_ = false;                     ///< the reserve is there
  std::set<std::filesystem::path> unsynced_;  ///< directories with new names in them
};

}  // namespace parray
