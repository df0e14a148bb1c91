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
  /// For people: "43.1 %", `share`, or, in passes, whose end nobody knows, what is merged: "57.3
  /// samples a pixel".
  [[nodiscard]] std::string amount_text(double share) const;
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

  /// Takes finished rows, for the next commit(). Throws RunError.
  void keep(const RowBlock& block);
  /// What has been kept is on the disk when it returns. Throws RunError.
  void commit();

  /// Everything pending is merged: begins the next pass, as Job::next_pass() does; false if there
  /// is none. All rows of the pass before have to be kept before any of the next.
  bool next_pass(Time now);
  /// Not every one was: rows of later passes would be worthless, and are not kept.
  void keep_no_more() { closed_ = true; }

  /// The job is done. In a directory that the user has named its picture and report take the place
  /// of its rows.
  void keep_picture(const Picture& picture);

  /// The picture is written: a directory that the user has not named goes.
  void forget();

 private:
  void open_store();
  void put_held();
  [[nodiscard]] bool same_picture(const JobRecord& kept) const;

  std::filesystem::path directory_;
  bool named_;
  Job job_;
  double taken_up_ = 0;
  Epoch next_epoch_ = 0;
  std::unique_ptr<SqliteStore> store_;  ///< null until there is something to keep
  std::vector<std::string> held_;       ///< blocks for the next commit()
  std::size_t held_bytes_ = 0;
  bool new_pass_ = false;  ///< the store does not know of the latest pass yet
  bool closed_ = false;    ///< takes no more rows: some of an earlier pass are lost
};

}  // namespace parray
