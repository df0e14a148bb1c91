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
#include "coordinator/store/disk.h"
#include "coordinator/store/inspection.h"
#include "coordinator/store/row_log.h"
#include "coordinator/store/state_files.h"
#include "coordinator/store/store.h"

namespace parray::store {

/// A job's log of finished rows.
struct RowLog {
  std::uint64_t number = 0;     ///< of its file
  std::uint64_t committed = 0;  ///< bytes of its file
  FreshRows fresh{};            ///< entries that are to follow them
};

/// Keeps everything below one directory: records in DIR/parray.sqlite (SQLite, write-ahead log,
/// synced at every commit), bulk data in the plain files of state_files.h, each byte written once.
/// Beside each record stands a copy (job_file.h), from which a lost database can be built again.
///
/// What commit() has returned for survives the death of the process and of the machine at any
/// moment. A commit makes the bulk data durable first and names it in the database last; a file
/// goes only after the commit that forgets it. So whatever a crash leaves, the database names only
/// what is there. Opening moves files that it does not name to lost/ and deletes none of them.
///
/// On a full disk a commit holds back the jobs whose rows found no room, keeps the rest, and so
/// frees what was dropped, before it throws.
///
/// Rows are checked when they are read, so that the damaged file of one job is no other's trouble.
class DiskStore final : public Store {
 public:
  /// Makes the directory if need be. Reads no bulk data. `disk` outlives
  /// this.
  ///
  /// Throws StateInUse when another coordinator uses it, InputError when the directory cannot be
  /// used, is of another version or lacks even the room to open; StateDamaged (schema.h) when the
  /// database is damaged or has lost commits.
  explicit DiskStore(const std::filesystem::path& directory, Disk& disk = system_disk());
  ~DiskStore() override;
  DiskStore(const DiskStore&) = delete;
  DiskStore& operator=(const DiskStore&) = delete;

  void put_job(const JobRecord& job) override;
  void put_scene(const std::string& digest, std::string_view bytes) override;
  void append_rows(JobId job, std::string entry) override;
  void drop_rows(JobId job) override;
  void keep_rows(JobId job, std::uint64_t entries) override;
  void put_picture(JobId job, std::span<const std::string_view> pieces) override;
  void drop_work(JobId job) override;
  void drop_job(JobId job) override;
  void put_note(const std::string& name, const std::string& text) override;
  void put_mark(const std::string& text) override;
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
  /// What opening has found and mended, a line each.
  [[nodiscard]] const std::vector<std::string>& reports() const { return reports_; }

 private:
  struct JobEntry {
    std::string scene;  ///< digest
    bool unfinished = false;
    bool has_record = false;
    std::optional<RowLog> log{};
    std::optional<KeptPicture> picture{};
  };
  /// What the database does not know yet of a job.
  struct Change {
    bool record = false;
    std::string text{};  ///< of the record; empty: the job is dropped
    bool log = false;
    bool picture = false;
    bool copy = false;                            ///< job.json has to be written again
    std::vector<std::filesystem::path> doomed{};  ///< files to remove once it is committed
    [[nodiscard]] bool drops() const { return record && text.empty(); }
  };

  // disk_store_opening.cpp
  void open();
  Records read_database(const FoundFiles& found);
  void keep_up(const Upkeep& upkeep, const FoundFiles& found, const Records& records);
  void load(const Records& records);
  void take_stock();

  void drop_log(JobId job, JobEntry& entry);
  void drop_picture(JobId job, JobEntry& entry);
  void check_place() const;
  std::set<JobId> write_logs(std::exception_ptr& failure);
  [[nodiscard]] std::vector<std::string> unused_scenes(const std::set<JobId>& held_back) const;
  [[nodiscard]] bool frees_room(const std::vector<std::string>& unused) const;
  void keep(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void write_copies(const std::set<JobId>& held_back);
  void rewrite_scenes();
  void write_copy(JobId job, const Change& change);
  std::string record_of(JobId job, const Change& change);
  void record(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void record_mark(bool everything);
  void record_change(JobId job, const Change& change);
  void settle(const std::set<JobId>& held_back, const std::vector<std::string>& unused);
  void settle_change(JobId job, const Change& change);
  void put_in_place(const std::filesystem::path& next, const std::filesystem::path& current);
  [[nodiscard]] const JobEntry* find(JobId job) const;
  [[nodiscard]] std::uint64_t uptime();

  StateFiles files_;
  std::unique_ptr<Database> database_;

  // What there is, with everything that was put and dropped since the last commit.
  std::map<JobId, JobEntry> jobs_;
  std::map<std::string, WholeFile> scenes_;

  // What of it the database does not know yet.
  std::map<JobId, Change> changes_;
  std::map<std::string, std::string> new_scenes_;  ///< bytes that the next commit syncs, or none
  std::map<std::string, std::string> new_notes_;
  std::optional<std::string> new_mark_;
  std::optional<std::string> new_reached_mark_;
  bool sync_failed_ = false;     ///< what was written before it may be lost
  bool scenes_dropped_ = false;  ///< there may be scenes that nobody uses

  std::uint64_t batch_ = 0;       ///< commits so far
  bool counts_commits_ = false;   ///< the file `commits` is there
  bool log_is_fresh_ = true;      ///< nothing was committed since tidy()
  std::uint64_t lost_bytes_ = 0;  ///< below lost/
  std::vector<std::string> reports_;
};

}  // namespace parray::store
