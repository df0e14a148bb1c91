#pragma once

#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/store/database.h"
#include "coordinator/store/inspection.h"
#include "coordinator/store/row_log.h"

namespace parray::store {

/// Error: the state's database is damaged. parray-coordinator --check lists the damage, --repair
/// repairs it.
class StateDamaged : public RunError {
 public:
  /// `damage`: at least one line, one for each damage. The message has the first line and the
  /// number of further lines.
  StateDamaged(const std::filesystem::path& directory, const std::vector<std::string>& damage);
};

/// A job's log of results.
struct RowLog {
  std::uint64_t number = 0;     ///< of its file, see StateFiles
  std::uint64_t committed = 0;  ///< committed bytes of its file
  PendingRows pending{};        ///< entries that the next commit appends
};

/// A store in one directory. Records are in DIR/parray.sqlite (SQLite, write-ahead log, synced at
/// every commit). Bulk data is in the plain files of state_files.h, each byte written once. A copy
/// of each record is a file, too (records.h), from which --repair rebuilds a lost database.
///
/// Once commit() has returned, its changes survive a crash of the process or machine at any moment.
/// A commit makes the bulk data durable first and then names it in the database. It removes files
/// only after the database no longer names them. So after any crash all files that the database
/// names exist. Opening moves other scenes, results and pictures to lost/. It deletes only
/// temporary files, uncommitted entries at the ends of logs, and files of a job that was being
/// dropped.
///
/// If the disk has no room for the results of some jobs, a commit holds back those jobs, commits
/// all others, removes dropped files, and then throws.
///
/// Results are checked when they are read. So a damaged file affects only its own job.
class DiskStore final : public Store {
 public:
  /// Opens the directory, which it creates if necessary. Reads no bulk data. `disk` must outlive
  /// this object.
  ///
  /// Throws StateInUse if another coordinator uses the directory; InputError if the directory
  /// cannot be used, has another version or no room for opening; StateDamaged if the
  /// database is damaged or has lost commits; RunError if a misplaced path cannot be moved to
  /// lost/.
  explicit DiskStore(const std::filesystem::path& directory, Disk& disk = system_disk());
  DiskStore& operator=(DiskStore&&) = delete;

  void put_job(const JobRecord& job) override;
  void put_scene(const std::string& digest, std::string_view bytes) override;
  void append_rows(JobId job, std::string entry) override;
  void drop_rows(JobId job) override;
  void keep_rows(JobId job, std::uint64_t entries) override;
  void put_picture(JobId job, std::span<const std::string_view> pieces) override;
  void drop_work(JobId job) override;
  void drop_job(JobId job) override;
  void put_note(const std::string& name, const std::string& text) override;
  void put_mark(const std::string& text) override { new_mark_ = text; }
  void put_reached_mark(const std::string& text) override;
  void commit() override;

  Usage usage() override;
  std::string note(const std::string& name) override;
  std::map<std::string, std::string> notes() override;
  std::string mark() override;
  std::string reached_mark() override { return note(std::string(own_note::reached)); }
  std::vector<JobRecord> jobs() override;
  std::optional<std::string> scene(const std::string& digest) override;
  void each_rows(JobId job, const RowsVisitor& visit) override;
  std::optional<std::string> picture(JobId job) override;
  std::uint64_t picture_bytes(JobId job) override;
  bool lacks_files() override;

  void tidy(double keep_lost) override;
  /// Returns one line for each damage that opening has found, and for each file that it has moved
  /// to lost/. Missing files stay missing.
  [[nodiscard]] const std::vector<std::string>& reports() const { return reports_; }

 private:
  struct JobEntry {
    std::string scene;  ///< digest
    bool unfinished = false;
    bool has_record = false;
    std::optional<RowLog> log{};
    std::optional<KeptPicture> picture{};
  };
  /// The changes of a job since the last commit.
  struct Change {
    bool record = false;
    std::string text{};  ///< new record; empty: the job is dropped
    bool log = false;
    bool picture = false;
    bool copy = false;                                     ///< job.json must be rewritten
    std::vector<std::filesystem::path> files_to_remove{};  ///< after the commit
    [[nodiscard]] bool drops() const { return record && text.empty(); }
  };

  // disk_store_opening.cpp
  void open();
  Records read_database(const FoundFiles& found);
  void apply_upkeep(const Upkeep& upkeep, const FoundFiles& found, const Records& records);
  void load(const Records& records);
  void check_files();

  void drop_log(JobId job, JobEntry& entry);
  void drop_picture(JobId job, JobEntry& entry);
  std::set<JobId> write_logs(std::exception_ptr& failure);
  [[nodiscard]] std::vector<std::string> unused_scenes(const std::set<JobId>& held_back) const;
  [[nodiscard]] bool frees_room(const std::vector<std::string>& unused) const;
  void write(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void write_copies(const std::set<JobId>& held_back);
  void write_copy(JobId job, const Change& change);
  std::string record_of(JobId job, const Change& change);
  void write_records(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void write_mark(bool everything);
  void write_change(JobId job, const Change& change);
  void finish(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void finish_change(JobId job, const Change& change);
  void put_in_place(const std::filesystem::path& next, const std::filesystem::path& current);
  [[nodiscard]] const JobEntry* find(JobId job) const;
  [[nodiscard]] std::uint64_t uptime();

  StateFiles files_;
  std::unique_ptr<Database> database_;

  // The content, including all changes since the last commit.
  std::map<JobId, JobEntry> jobs_;
  std::map<std::string, WholeFile> scenes_;

  // The changes since the last commit.
  std::map<JobId, Change> changes_;
  std::map<std::string, std::string> new_scenes_;  ///< bytes; empty if they are on the disk
  std::map<std::string, std::string> new_notes_;
  std::optional<std::string> new_mark_;
  std::optional<std::string> new_reached_mark_;
  bool sync_failed_ = false;     ///< earlier writes may be lost
  bool scenes_dropped_ = false;  ///< there may be scenes that no job uses

  std::uint64_t batch_ = 0;            ///< number of commits
  bool counts_commits_ = false;        ///< the file `commits` exists
  bool database_log_is_empty_ = true;  ///< nothing was committed since tidy()
  std::uint64_t lost_bytes_ = 0;       ///< size of the files below lost/
  std::vector<std::string> reports_;
};

}  // namespace parray::store
