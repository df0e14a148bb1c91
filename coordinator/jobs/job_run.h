#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/picture_bytes.h"
#include "common/scene/settings_fwd.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

struct FaultFinding;  // machines.h

/// A copy of the numbers of a run, for a thread that must not use the run itself.
struct RunState {
  std::shared_ptr<const WorkPlan> plan;  ///< of the current pass; null before the first pass
  std::uint32_t pass = 0;                ///< number of the current pass
  std::vector<std::uint64_t> passes;     ///< samples of each pass that has begun
  std::uint64_t cells = 0;               ///< merged cells of the current pass
  std::uint64_t samples = 0;             ///< merged samples of all passes
  std::uint64_t expected_samples = 0;    ///< samples of the finished picture; 0: unknown
  bool whole = false;                    ///< every pixel has a sample
  ErrorFigures error;
};
/// Returns the finished share of the work, 0 to 1. `elapsed`: the part of the time limit that has
/// passed, in seconds. For a job in passes the share is an estimate, which falls if a later pass
/// needs more samples.
double share_done(const RenderSettings& settings, const RunState& state, double elapsed);

/// One job from its first pass to its finished picture: its record, its picture, and the copies of
/// both in the store. In the service the job thread uses it, in parray-mpi rank 0. A later run of
/// the job continues from the last commit.
///
/// Not thread-safe. All functions may throw what Store throws.
class JobRun {
 public:
  using OpenStore = std::function<Store*()>;
  /// Tells replay() how to treat a damaged entry of the log.
  enum class OnDamage : std::uint8_t { fail, cut, stop };

  /// Makes a run that adds each result to `store` at once. Null: the run saves nothing.
  explicit JobRun(JobRecord record, Store* store = nullptr)
      : JobRun(std::move(record), store, {}) {}
  /// Makes a run that buffers results in memory until pack_next() or commit(). `open` returns the
  /// store. If `store` is null, the run calls `open` when it first writes results or, in finish(),
  /// the picture.
  JobRun(JobRecord record, Store* store, OpenStore open)
      : record_(std::move(record)), store_(store), open_(std::move(open)) {}

  /// Makes the picture, without samples. Call it first. The arguments are those of JobPicture.
  void create_picture(const SceneFacts& scene, bool large_pages = true, PictureJudge judge = {});
  /// Merges the results of earlier runs. At a damaged entry of the log, `fail` throws RunError or
  /// DecodeError; `cut` removes this entry and all later ones; `stop` leaves the log as it is.
  /// Returns the damage. Empty: none.
  std::string replay(OnDamage on_damage);
  /// Begins the next pass, unless the current one is unfinished. Returns false if the picture is
  /// complete. `at`: seconds since 1970. Without it the journal gets no entry.
  bool begin_pass(const PassTimes& times = {}, std::optional<double> at = {});

  /// Merges a new result and adds it to the log. `packed`: its bytes, see pack_cells().
  ResultCollector::Taken take(TracerKey tracer, const TracedCells& cells, std::string_view packed);
  /// Buffers a result for the log. picture() contains it already.
  void keep(TracerKey tracer, TracedCells cells);
  /// Adds to picture and log that `tracer` got the same bits for these cells.
  void note_check(TracerKey tracer, const CellRange& range);
  /// Adds to picture and log that a check of these cells is wanted.
  void note_wanted(const CellRange& range);
  /// Adds entries to the journal and to the log.
  void add_to_journal(const std::vector<JournalEntry>& entries);
  /// Retracts the results and checks of a faulty machine: in picture, log and record. Returns
  /// nothing if the picture does not rely on the machine. `at`: seconds since 1970.
  std::optional<JobPicture::Retraction> retract(const FaultFinding& finding, double at);
  /// Calls retract() for each finding in the store that is newer than the record. Throws RunError
  /// if the store's note of workers is damaged.
  void retract_faulty(double at);
  /// Adds to the log that picture() lost these cells.
  void keep_retraction(const std::vector<CellRange>& cells);
  /// Removes all results from log and record, because picture() was begun again.
  void drop_results();

  /// Returns whether the buffered results need much memory. If so, call pack_next().
  [[nodiscard]] bool buffer_full() const;
  /// Packs some buffered results and gives them to the store, which takes milliseconds. Returns
  /// false if there were none.
  bool pack_next();
  /// Drops the buffered results.
  void clear_buffer();
  /// Packs all buffered results and writes them and the record to the disk. The service does not
  /// need it: the service commits its store itself.
  void commit();

  /// Marks the job as done, and replaces its log by picture and report. `journal`: bytes that
  /// follow the picture in its file. After StorageFull, call it again.
  void finish(const Image& image, const PictureStatistics& statistics, std::string report,
              std::string_view journal = {});

  /// Replaces the record by a newer one and gives it to the store. The run keeps its own passes and
  /// fault findings, because these are the latest.
  void put(JobRecord record);
  [[nodiscard]] JobRecord& record() { return record_; }
  [[nodiscard]] JobPicture& picture() { return *picture_; }
  /// Returns the number of samples of earlier runs.
  [[nodiscard]] std::uint64_t samples_before() const { return samples_before_; }
  /// Returns the state. Call it only after the first pass has begun.
  [[nodiscard]] RunState state() const;

 private:
  /// A buffered entry of the log.
  struct Held {
    std::size_t bytes;                  ///< memory of its result; 0: none
    std::function<std::string()> pack;  ///< returns the entry
  };
  void append(std::string entry);
  void put_record();
  [[nodiscard]] std::vector<JournalEntry> entries_of_pass(double at) const;

  JobRecord record_;
  Store* store_;
  OpenStore open_;  ///< empty: the run buffers nothing
  std::unique_ptr<JobPicture> picture_;
  std::uint64_t samples_before_ = 0;
  std::deque<Held> held_;
  std::size_t held_bytes_ = 0;
};

}  // namespace parray::coordinator
