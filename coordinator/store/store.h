#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "coordinator/store/job_record.h"

namespace parray::store {

/// The disk does not accept a change now: it is full, fails, or is not writable, or a standby has
/// not stored the change. `what()` says which. Committed data is safe, and the store continues to
/// work; see Store.
class StorageFull : public RunError {
 public:
  using RunError::RunError;
};

/// A committed file is damaged, cut or missing. `what()` names the file and the damage.
class DamagedFile : public RunError {
 public:
  using RunError::RunError;
};

/// Another process uses the state. `what()` names the directory.
class StateInUse : public InputError {
 public:
  using InputError::InputError;
};

/// Stores jobs, scenes, results and pictures. Tests replace the store to simulate failures.
///
/// A change is stored only after commit() has returned; the coordinator acknowledges nothing
/// earlier. Members that read see new data at once, and no longer see dropped data after the commit
/// at the latest. A new process finds the state of the latest commit.
///
/// Every member may throw RunError (a file is damaged or cannot be used), including StorageFull.
/// A put_scene() or put_picture() that throws has changed nothing: call it again when there is
/// room. A commit() that throws has stored, of each job, all changes or none. It forgets no change
/// and may be called again.
///
/// Not thread-safe.
class Store {
 public:
  virtual ~Store() = default;

  virtual void put_job(const JobRecord& job) = 0;  ///< adds a job, or replaces the one with its id
  /// Adds a scene. Does nothing if the store has a scene with this digest. Throws std::logic_error
  /// unless `digest` is 64 lower-case hexadecimal digits.
  virtual void put_scene(const std::string& digest, std::string_view bytes) = 0;
  /// Appends an entry of opaque bytes to the job's log of results. Keeps the entries in order, and
  /// in memory until the commit.
  virtual void append_rows(JobId job, std::string entry) = 0;
  virtual void drop_rows(JobId job) = 0;  ///< empties the job's log of results
  /// Keeps the first `entries` committed entries of the job's log and drops all others.
  virtual void keep_rows(JobId job, std::uint64_t entries) = 0;
  /// Adds or replaces the job's picture. The file consists of the pieces in order.
  virtual void put_picture(JobId job, std::span<const std::string_view> pieces) = 0;
  /// Empties the job's log of results. The commit then drops all scenes that no job needs: see
  /// needs_scene().
  virtual void drop_work(JobId job) = 0;
  virtual void drop_job(JobId job) = 0;  ///< drops the job with all its data
  /// Adds or replaces a named text.
  virtual void put_note(const std::string& name, const std::string& text) = 0;
  /// Sets the mark of the next commit: a text that describes exactly the committed content. A
  /// commit that holds back a job, or before which no mark was put, leaves no mark.
  virtual void put_mark(const std::string& text) = 0;
  /// Sets the reached mark of the next commit: a text that describes a part of the content. The
  /// commit leaves no mark. A commit that holds back a job does not store the reached mark.
  virtual void put_reached_mark(const std::string& text) = 0;
  /// Stores all changes durably and frees the room of dropped data before it returns.
  virtual void commit() = 0;

  /// Bytes of scenes, results and pictures on the disk. A scene of several jobs counts once in
  /// `total`, and fully for each of these jobs in `jobs`. `total` includes files in lost/.
  struct Usage {
    std::uint64_t total = 0;
    std::map<JobId, std::uint64_t> jobs{};
  };
  virtual Usage usage() = 0;
  virtual std::string note(const std::string& name) = 0;  ///< empty: no such note
  virtual std::map<std::string, std::string> notes() = 0;
  virtual std::string mark() = 0;  ///< empty: none
  /// Returns the latest committed mark or reached mark. The store has all that it describes.
  virtual std::string reached_mark() = 0;
  virtual std::vector<JobRecord> jobs() = 0;  ///< by ascending id
  virtual std::optional<std::string> scene(const std::string& digest) = 0;
  using RowsVisitor = std::function<void(std::string_view entry)>;
  /// Calls `visit` with each entry of the job's log, oldest first. `visit` must not call the store.
  virtual void each_rows(JobId job, const RowsVisitor& visit) = 0;
  /// Returns the content of the picture's file; nothing: the job has no picture. Throws DamagedFile
  /// if the file differs from what was put.
  virtual std::optional<std::string> picture(JobId job) = 0;
  /// Replaces the job's picture by the standby's copy. Returns false if there is no such copy.
  virtual bool restore_picture(JobId /*job*/) { return false; }
  virtual std::uint64_t picture_bytes(JobId job) = 0;  ///< size of the picture; 0: no picture
  /// Returns whether committed files are missing or too short. Does not read their content.
  virtual bool lacks_files() { return false; }

  /// Removes files that moved to lost/ more than `keep_lost` seconds of uptime ago, and empties the
  /// write-ahead log. Call it every few seconds.
  virtual void tidy(double keep_lost) = 0;
};

/// Name of the note with the uptime: the seconds for which coordinators have served this state.
inline constexpr const char* uptime_note = "uptime";

}  // namespace parray::store
