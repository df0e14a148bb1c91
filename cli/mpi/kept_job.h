#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/client.h"
#include "coordinator/job.h"
#include "coordinator/sqlite_store.h"

namespace parray {

/// The one job of an mpirun, kept in the store that a coordinator keeps its jobs in, so that either
/// goes on with what the other has begun.
class KeptJob {
 public:
  /// Takes up the unfinished job of the same scene and picture settings in `directory`, if there is
  /// one; else begins a new one, of which nothing is kept before keep() is called.
  ///
  /// `named`: the user has named the directory, and it stays; else it goes when the job is done.
  /// Throws InputError or RunError as SqliteStore does.
  KeptJob(Submission submission, std::filesystem::path directory, bool named);

  [[nodiscard]] Job& job() { return job_; }
  [[nodiscard]] const Job& job() const { return job_; }
  /// Share that earlier lives have finished, 0 .. 1.
  [[nodiscard]] double taken_up() const { return taken_up_; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  /// Keeps finished rows; when it returns they are on the disk. Throws RunError.
  void keep(const RowBlock& block);

  /// The job is done. In a directory that the user has named its picture and report take the place
  /// of its rows.
  void keep_picture(const Picture& picture);

  /// The picture is written: a directory that the user has not named goes.
  void forget();

 private:
  void open_store();
  [[nodiscard]] bool same_picture(const JobRecord& kept) const;

  std::filesystem::path directory_;
  bool named_;
  Job job_;
  double taken_up_ = 0;
  Epoch next_epoch_ = 0;
  std::unique_ptr<SqliteStore> store_;  ///< null until there is something to keep
};

}  // namespace parray
