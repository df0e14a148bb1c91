#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "cli/farm/client.h"
#include "coordinator/jobs/job_run.h"
#include "coordinator/store/disk_store.h"

namespace parray::mpi {

/// The job of an mpirun, and the directory of its store. A coordinator's store has the same format,
/// so each can continue a job of the other.
class CheckpointedJob {
 public:
  /// Resumes the unfinished job of the same picture in `directory`, if there is one, with the plan
  /// of that job (schedule, row order, progressive and tile). Otherwise begins a new job with
  /// `tile` (see WorkPlan), and makes the store when there are results to save.
  ///
  /// `named`: the user has named the directory, so forget() does not remove it. Throws InputError
  /// or RunError as DiskStore does, and RunError if the saved job is damaged.
  CheckpointedJob(Submission submission, std::uint32_t tile, std::filesystem::path directory,
                  bool named);
  CheckpointedJob& operator=(CheckpointedJob&&) = delete;

  [[nodiscard]] JobRun& run() { return *run_; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  /// Returns the encoded scene (scene_to_bytes()).
  [[nodiscard]] const std::string& scene_bytes() const { return scene_bytes_; }
  /// Returns the scene. This object then has it no more.
  std::shared_ptr<const Scene> take_scene() { return std::move(scene_); }
  /// Returns a new copy of the scene, made from its bytes.
  [[nodiscard]] std::shared_ptr<const Scene> copy_scene() const;
  /// Returns the finished work as text: "43.1 %". A picture in passes has no known number of
  /// samples in advance, so its text is "57.3 samples per pixel". Call it only after the first pass
  /// has begun.
  [[nodiscard]] std::string amount_text() const;

  /// Call when the picture is complete. Drops results that are not saved yet. In a directory that
  /// the user has named, marks the job as done, and replaces the saved results by picture and
  /// report.
  void keep_picture(const Picture& picture);
  /// Removes the job's files, and then the directory if it is empty. Does nothing if the user has
  /// named the directory. Call when the picture file is written. Afterwards do not use run().
  void forget();

 private:
  std::filesystem::path directory_;
  bool named_;
  std::shared_ptr<const Scene> scene_;
  std::string scene_bytes_;
  std::unique_ptr<DiskStore> store_;  ///< null until there are results to save
  std::unique_ptr<JobRun> run_;
};

}  // namespace parray::mpi
