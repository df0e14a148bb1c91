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

/// There is no room for what was to be kept, or the disk took only a part of it. `what()` names the
/// directory. Nothing that was committed is lost and the store goes on working; see Store.
class StorageFull : public RunError {
 public:
  using RunError::RunError;
};

/// A file that was kept is damaged, cut or gone. `what()` names it and says what is wrong.
class DamagedFile : public RunError {
 public:
  using RunError::RunError;
};

/// Another process uses the state. `what()` names the directory.
class StateInUse : public InputError {
 public:
  using InputError::InputError;
};

/// Where jobs, scenes, finished rows and pictures are kept: the seam to the disk.
///
/// Nothing counts as kept before commit() has returned; the coordinator acknowledges nothing
/// earlier. What was put is seen by the readers at once, what was dropped from the commit on at the
/// latest. Without a commit, the next life finds the state of the last one.
///
/// Every member may throw RunError (a file is damaged or cannot be used), StorageFull among them.
/// A put_scene() or put_picture() that throws has put nothing: call it again when there is room. A
/// commit() that throws has kept, of each job, all or nothing of what was put and dropped; it
/// forgets none of it, and may be called again.
///
/// One thread at a time.
class Store {
 public:
  virtual ~Store() = default;

  virtual void put_job(const JobRecord& job) = 0;  ///< new, or in place of the one with its id
  /// `digest`: 64 lower-case hexadecimal digits, or std::logic_error. Nothing happens if there is a
  /// scene of that digest: the bytes are taken to be the same.
  virtual void put_scene(const std::string& digest, std::string_view bytes) = 0;
  /// Appends to the job's log of finished rows. Entries are opaque bytes; order is kept. They are
  /// held in memory until the commit.
  virtual void append_rows(JobId job, std::string entry) = 0;
  virtual void drop_rows(JobId job) = 0;  ///< the log is empty again
  /// Of the job's log the first so many entries are kept, and the rest, which is damaged, goes.
  virtual void keep_rows(JobId job, std::uint64_t entries) = 0;
  /// The picture, in place of an earlier one: the pieces one after the other are the file.
  virtual void put_picture(JobId job, std::span<const std::string_view> pieces) = 0;
  /// The job's rows are no longer needed; nor is a scene that no unfinished job uses at the commit.
  virtual void drop_work(JobId job) = 0;
  virtual void drop_job(JobId job) = 0;  ///< with everything that is kept of it
  /// A text by name, in place of the one before.
  virtual void put_note(const std::string& name, const std::string& text) = 0;
  /// A text that stands for exactly what is kept: a commit that keeps everything keeps the mark
  /// that was put; any other commit, of a part or without a mark of its own, leaves none.
  virtual void put_mark(const std::string& text) = 0;
  /// What the text stands for is here, and more: a commit that keeps everything keeps it for
  /// reached_mark(), and leaves no mark.
  virtual void put_reached_mark(const std::string& text) = 0;
  /// What was put before is kept, durably, when it returns; room of what was dropped is free.
  virtual void commit() = 0;

  /// Bytes on the disk. A scene counts once in `total`, and for each job that has it. `total`
  /// includes files that were set aside.
  struct Usage {
    std::uint64_t total = 0;
    std::map<JobId, std::uint64_t> jobs{};
  };
  virtual Usage usage() = 0;
  virtual std::string note(const std::string& name) = 0;  ///< empty: there is none
  virtual std::map<std::string, std::string> notes() = 0;
  virtual std::string mark() = 0;  ///< empty: there is none
  /// The latest mark that was kept. All that it stands for is still here, and perhaps more.
  virtual std::string reached_mark() = 0;
  virtual std::vector<JobRecord> jobs() = 0;  ///< by ascending id
  virtual std::optional<std::string> scene(const std::string& digest) = 0;
  using RowsVisitor = std::function<void(std::string_view entry)>;
  /// Calls `visit` with each entry of the job's log, oldest first. `visit` must not call the store.
  virtual void each_rows(JobId job, const RowsVisitor& visit) = 0;
  /// The whole file. Throws DamagedFile when it is not what was put.
  virtual std::optional<std::string> picture(JobId job) = 0;
  /// Replaces the job's picture by the copy that another store has. False: there is no such copy.
  virtual bool restore_picture(JobId /*job*/) { return false; }
  virtual std::uint64_t picture_bytes(JobId job) = 0;  ///< its size; 0: there is none
  /// Whether files of scenes, rows or pictures that were committed are gone or cut. Reads none.
  virtual bool lacks_files() { return false; }

  /// Work for quiet moments: call it every few seconds. Removes what was set aside more than
  /// `keep_lost` seconds of uptime ago.
  virtual void tidy(double keep_lost) = 0;
};

/// Name of the note that holds the seconds for which coordinators have served this state.
inline constexpr const char* uptime_note = "uptime";

}  // namespace parray::store
