#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/farm/client.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/disk_store.h"
#include "proto/clock.h"

namespace parray::mpi {

/// The job of an mpirun: its unfinished picture, saved in a store. A coordinator's store has the
/// same format, so each can continue a job of the other.
class CheckpointedJob {
 public:
  /// Resumes the unfinished job of the same picture in `directory`, if there is one, with its plan
  /// (schedule, row order and `tile`, see WorkPlan). Otherwise begins a new job, and saves nothing
  /// before commit().
  ///
  /// `named`: the user has named the directory. forget() removes other directories. Throws
  /// InputError or RunError as DiskStore does, and RunError if the saved job is damaged.
  CheckpointedJob(Submission submission, std::uint32_t tile, std::filesystem::path directory,
                  bool named);

  [[nodiscard]] const JobRecord& record() const { return record_; }
  [[nodiscard]] const std::string& scene_bytes() const { return scene_bytes_; }
  /// Returns the scene. This object then has it no more.
  std::shared_ptr<const Scene> take_scene() { return std::move(scene_); }
  /// Returns a new copy of the scene, made from its bytes.
  [[nodiscard]] std::shared_ptr<const Scene> copy_scene() const;
  [[nodiscard]] JobPicture& picture() { return *picture_; }
  [[nodiscard]] const JobPicture& picture() const { return *picture_; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  /// Returns whether an earlier run has saved results.
  [[nodiscard]] bool resumed() const { return samples_before_ > 0; }
  /// Returns the number of samples of earlier runs.
  [[nodiscard]] std::uint64_t samples_before() const { return samples_before_; }
  /// Returns the finished share of the work, 0 to 1, `elapsed` after the beginning of this run. For
  /// a job with a target it is an estimate, which may fall.
  [[nodiscard]] double progress(Time elapsed) const;
  /// Returns the finished work as text: "43.1 %". For a picture in passes, whose number is unknown:
  /// "57.3 samples a pixel".
  [[nodiscard]] std::string amount_text() const;

  /// Begins the next pass, unless the current one is unfinished. Returns false if the picture is
  /// complete.
  bool begin_pass(const PassTimes& times = {});

  /// Buffers merged results of the current pass for the store. While buffer_full(), call
  /// pack_next().
  void keep(TracerKey tracer, TracedCells cells);
  /// Buffers an entry for cells that were set back.
  void retract(const std::vector<CellRange>& cells);
  /// Drops all saved results, because the picture is begun again.
  void restart();
  /// Adds an error in results that was found and repaired, for the report.
  void add_flag(const std::string& text);
  /// Returns whether the buffered results need much memory.
  [[nodiscard]] bool buffer_full() const;
  /// Packs some buffered results for the store, which takes milliseconds. Returns false if there
  /// were none.
  bool pack_next();
  /// Writes all results to the disk. Throws RunError.
  void commit();

  /// Marks the job as done. In a directory that the user has named, replaces its rows by picture
  /// and report.
  void keep_picture(const Picture& picture);
  /// Removes the directory, unless the user has named it. Call when the picture file is written.
  void forget();

 private:
  bool resume(JobRecord& kept);
  void replay();
  void open_store();

  std::filesystem::path directory_;
  bool named_;
  std::shared_ptr<const Scene> scene_;
  std::string scene_bytes_;
  JobRecord record_;
  std::unique_ptr<JobPicture> picture_;
  std::uint64_t samples_before_ = 0;
  std::unique_ptr<DiskStore> store_;  ///< null until there are results to save
  struct Held {
    std::uint32_t pass;
    TracerKey tracer;
    std::shared_ptr<const CellGrid> grid;
    TracedCells cells;
    std::string retraction{};  ///< entry of cells that were set back; `cells` is then empty
  };
  std::deque<Held> held_;
  std::size_t held_bytes_ = 0;
};

}  // namespace parray::mpi
