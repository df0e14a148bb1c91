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

/// The one job of an mpirun: its picture under way, kept in the store that a coordinator keeps its
/// jobs in, so that either goes on with what the other has begun.
class CheckpointedJob {
 public:
  /// Takes up the unfinished job of the same picture in `directory`, if there is one, with its plan
  /// (schedule, row order and `tile`, see WorkPlan); else begins a new one, of which nothing is
  /// kept before commit() is called.
  ///
  /// `named`: the user has named the directory, and it stays; else it goes when the job is done.
  /// Throws InputError or RunError as DiskStore does, RunError when what is kept is damaged.
  CheckpointedJob(Submission submission, std::uint32_t tile, std::filesystem::path directory,
                  bool named);

  [[nodiscard]] const JobRecord& record() const { return record_; }
  [[nodiscard]] const std::string& scene_bytes() const { return scene_bytes_; }
  /// Let go by whoever takes it.
  std::shared_ptr<const Scene> take_scene() { return std::move(scene_); }
  /// The scene once more, from its bytes.
  [[nodiscard]] std::shared_ptr<const Scene> scene_again() const;
  [[nodiscard]] JobPicture& picture() { return *picture_; }
  [[nodiscard]] const JobPicture& picture() const { return *picture_; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  /// Earlier lives have finished something.
  [[nodiscard]] bool taken_up() const { return samples_before_ > 0; }
  /// Samples of earlier lives.
  [[nodiscard]] std::uint64_t samples_before() const { return samples_before_; }
  /// Share of the work that is done `elapsed` after this life's beginning, 0 .. 1; with a target an
  /// estimate, which may fall.
  [[nodiscard]] double progress(Time elapsed) const;
  /// How much that is, for people: "43.1 %", or, in passes, whose end nobody knows, "57.3 samples a
  /// pixel".
  [[nodiscard]] std::string amount_text() const;

  /// All of the pass under way is in, or there is none yet: begins the next; false when the picture
  /// is complete.
  bool begin_pass(const PassTimes& times = {});

  /// Takes what has been merged of the pass under way, for the store. What waits is in memory:
  /// while holds_much(), pack_some() is due.
  void keep(TracerKey tracer, TracedCells cells);
  /// The same of cells that were set back.
  void retract(const std::vector<CellRange>& cells);
  /// Drops everything kept so far, because the picture is begun again.
  void restart();
  /// What was found wrong and mended, for the report.
  void add_flag(const std::string& text);
  [[nodiscard]] bool holds_much() const;
  /// Packs some of what waits, which takes milliseconds; false when nothing was left.
  bool pack_some();
  /// All that was kept is on the disk when it returns. Throws RunError.
  void commit();

  /// The job is done. In a directory that the user has named its picture and report take the place
  /// of its rows.
  void keep_picture(const Picture& picture);
  /// The picture is written: a directory that the user has not named goes.
  void forget();

 private:
  bool take_up(JobRecord& kept);
  void replay();
  void open_store();

  std::filesystem::path directory_;
  bool named_;
  std::shared_ptr<const Scene> scene_;
  std::string scene_bytes_;
  JobRecord record_;
  std::unique_ptr<JobPicture> picture_;
  std::uint64_t samples_before_ = 0;
  std::unique_ptr<DiskStore> store_;  ///< null until there is something to keep
  struct Held {
    std::uint32_t pass;
    TracerKey tracer;
    std::shared_ptr<const CellGrid> grid;
    TracedCells cells;
    std::string retraction{};  ///< the entry; there are no cells then
  };
  std::deque<Held> held_;
  std::size_t held_bytes_ = 0;
};

}  // namespace parray::mpi
